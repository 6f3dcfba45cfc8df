// The tab with the map of SLAM or navigation.
'use strict';

(() => {
  const { css, mapping, show, text, visible } = page;
  let state = {};

  function measured(values) {
    for (const kind of ['map', 'origin', 'plans', 'pose', 'scan']) {
      if (values[kind] !== undefined) state[kind] = values[kind];
    }
    if (values.map) {
      const image = new Image();
      image.onload = () => { state.image = image; state.shown = values.map; };
      image.src = `data:image/png;base64,${values.map.png}`;
    }
  }

  // a pose or point in the frame of another pose
  function compose([x, y, yaw], [px, py, turn = 0]) {
    const [cos, sin] = [Math.cos(yaw), Math.sin(yaw)];
    return [x + cos * px - sin * py, y + sin * px + cos * py, yaw + turn];
  }

  const inMap = (pose) => (state.origin && pose ? compose(state.origin, pose) : null);

  function draw(canvas) {
    if (!state.image) return;
    const { image, shown: { corner, resolution } } = state;
    const corners = [[0, 0], [1, 0], [0, 1], [1, 1]].map(([i, j]) => compose(corner,
      [i * image.width * resolution, j * image.height * resolution]));
    const robot = inMap(state.pose);
    const drawing = mapping.begin(canvas, robot ? [...corners, robot] : corners, 1.04);
    if (!drawing) return;
    const { context, at, scale } = drawing;
    canvas.heading = ([x, y]) => (robot ? Math.atan2(y - robot[1], x - robot[0]) : 0);
    // from columns and rows of the image, the lowest row first, to pixels of the canvas
    const [left, top] = at(corner);
    const [cos, sin] = [Math.cos(corner[2]), Math.sin(corner[2])].map(
      (each) => each * resolution * scale);
    context.save();
    context.transform(-sin, -cos, -cos, sin, left, top);
    context.imageSmoothingEnabled = false;
    context.drawImage(image, 0, 0);
    context.restore();
    context.strokeStyle = '#8e4ec6';
    context.lineWidth = 2 * devicePixelRatio;
    for (const plan of state.plans || []) {
      const points = plan.in_odom ? plan.points.map(inMap) : plan.points;
      if (points.every(Boolean)) mapping.line(context, points.map(at));
    }
    if (robot) {
      if (state.scan) mapping.drawScan(drawing, state.scan, inMap(state.scan.pose || state.pose));
      mapping.drawRobot(drawing, robot, '#16a34a');
    }
    mapping.drawTarget(canvas, drawing);
  }

  page.add({
    selector: 'canvas.navigation',
    measured,
    reset: () => { state = {}; },
    draw: () => {
      show('[data-bind=place]', state.image && !inMap(state.pose) ? text('no_place') : '');
      for (const element of visible) if (element.matches('canvas.navigation')) draw(element);
    },
  });
})();
