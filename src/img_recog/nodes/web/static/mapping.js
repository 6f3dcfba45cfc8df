// What the maps of the tabs share: x is up and y is left, as in the simulator's picture from above.
//
// A canvas.map emits the event data-event when somebody clicks in it or drags: x, y, yaw, and
// whether it was dragged. Its function `heading` returns the yaw of a click at a place.
'use strict';

(() => {
  const DRAG_M = 0.1;
  const DRAG_PX = 8;

  // the corner and the side of a square around points
  function square(points, margin) {
    if (!points.length) return [-2.5, -2.5, 5];
    const xs = points.map((each) => each[0]);
    const ys = points.map((each) => each[1]);
    const size = Math.max(Math.max(...xs) - Math.min(...xs), Math.max(...ys) - Math.min(...ys), 2)
      * margin;
    return [(Math.max(...xs) + Math.min(...xs) - size) / 2,
      (Math.max(...ys) + Math.min(...ys) - size) / 2, size];
  }

  // clear a canvas to draw what is around points; null while it has no size
  // gutter: pixels that stay free at the left, and a half of it above and below
  function begin(canvas, points, margin, gutter = 0) {
    const side = Math.round(canvas.clientWidth * devicePixelRatio);
    if (!side) return null;
    if (canvas.width !== side) { canvas.width = side; canvas.height = side; }
    const [x, y0, inner] = square(points, margin);
    const size = inner / (1 - Math.min(0.5, gutter / canvas.clientWidth));
    const x0 = x - (size - inner) / 2;
    canvas.extent = [x0, y0, size];
    const scale = side / size;
    const at = ([x, y]) => [side - (y - y0) * scale, side - (x - x0) * scale];
    const context = canvas.getContext('2d');
    context.clearRect(0, 0, side, side);
    context.lineWidth = devicePixelRatio;
    context.font = `${11 * devicePixelRatio}px sans-serif`;
    return { context, at, scale, side };
  }

  function toMap(canvas, event) {
    const box = canvas.getBoundingClientRect();
    const [x, y, size] = canvas.extent || square([], 1);
    return [x + (box.bottom - event.clientY) / box.height * size,
      y + (box.right - event.clientX) / box.width * size];
  }

  function line(context, points) {
    context.beginPath();
    points.forEach(([x, y], index) => (index ? context.lineTo(x, y) : context.moveTo(x, y)));
    context.stroke();
  }

  function arrow(context, [x, y], yaw, size, color) {
    context.save();
    context.translate(x, y);
    context.rotate(-yaw - Math.PI / 2);
    context.fillStyle = color;
    context.beginPath();
    context.moveTo(size, 0);
    context.lineTo(-size * 0.7, size * 0.7);
    context.lineTo(-size * 0.35, 0);
    context.lineTo(-size * 0.7, -size * 0.7);
    context.closePath();
    context.fill();
    context.restore();
  }

  // the points that a laser scanner at a pose has seen
  function drawScan({ context, at }, scan, [x, y, yaw]) {
    context.fillStyle = '#dc2626';
    const dot = 2 * devicePixelRatio;
    scan.ranges.forEach((range, index) => {
      if (range === null) return;
      const angle = yaw + scan.angle_min + index * scan.angle_increment;
      const [px, py] = at([x + range * Math.cos(angle), y + range * Math.sin(angle)]);
      context.fillRect(px - dot / 2, py - dot / 2, dot, dot);
    });
  }

  // walls and things from above: first all edges, then all tops, which cover the edges of
  // triangles inside of a top
  function drawOutlines({ context, at }, outlines, edge, top) {
    for (const [color, width] of [[edge, 3], [top, 1]]) {
      context.strokeStyle = color;
      context.fillStyle = color;
      context.lineWidth = width * devicePixelRatio;
      for (const outline of outlines) {
        line(context, [...outline, outline[0]].map(at));
        context.fill();
      }
    }
  }

  // the left end of the base line of each name, at its robot, where no other name and no robot is
  // robots: x, y and the size of the arrow of each, in pixels
  function placeLabels(names, side, robots) {
    const height = 13 * devicePixelRatio;
    const placed = [];
    for (const [name, [robotX, robotY], width, gap] of names) {
      const right = Math.max(0, Math.min(robotX + gap, side - width - gap));
      const left = Math.max(0, robotX - gap - width);
      const isFree = ([x, y]) => placed.every(([, otherX, otherY, otherWidth]) => (
        Math.abs(y - otherY) >= height || x >= otherX + otherWidth || otherX >= x + width))
        && robots.every(([otherX, otherY, size]) => (y <= otherY - size
          || y - height >= otherY + size || x >= otherX + size || x + width <= otherX - size));
      const places = [0, 1, -1, 2, -2, 3, -3, 4, -4, 5, -5, 6, -6].flatMap(
        (row) => [[right, robotY + row * height], [left, robotY + row * height]]);
      placed.push([name, ...(places.find(isFree) || places[0]), width]);
    }
    return placed;
  }

  const robotSize = ({ scale }) => Math.max(10 * devicePixelRatio, 0.15 * scale);

  function drawRobot(drawing, pose, color, share = 1) {
    arrow(drawing.context, drawing.at(pose), pose[2], share * robotSize(drawing), color);
  }

  // where somebody points
  function drawTarget(canvas, drawing) {
    if (canvas.target) drawRobot(drawing, canvas.target, '#f59e0b');
  }

  document.addEventListener('pointerdown', (event) => {
    const canvas = event.target.closest && event.target.closest('canvas.map');
    if (!canvas || !event.isPrimary || event.button) return;
    event.preventDefault();
    canvas.setPointerCapture(event.pointerId);
    const place = toMap(canvas, event);
    canvas.target = [...place, canvas.heading ? canvas.heading(place) : 0];
    canvas.dragged = false;
  });
  document.addEventListener('pointermove', (event) => {
    const canvas = event.target;
    if (!canvas.target || !canvas.hasPointerCapture || !canvas.hasPointerCapture(event.pointerId)) {
      return;
    }
    const [x, y] = toMap(canvas, event);
    const [dx, dy] = [x - canvas.target[0], y - canvas.target[1]];
    if (Math.hypot(dx, dy) > Math.max(DRAG_M,
      DRAG_PX * (canvas.extent || square([], 1))[2] / canvas.clientWidth)) {
      canvas.target[2] = Math.atan2(dy, dx);
      canvas.dragged = true;
    }
  });
  document.addEventListener('pointerup', (event) => {
    const canvas = event.target;
    if (!canvas.target) return;
    const [x, y, yaw] = canvas.target;
    emitEvent(canvas.dataset.event, { x, y, yaw, dragged: canvas.dragged });
    canvas.target = null;
  });
  document.addEventListener('pointercancel', (event) => { event.target.target = null; });

  page.mapping = { begin, drawOutlines, drawRobot, drawScan, drawTarget, line, placeLabels,
    robotSize };
})();
