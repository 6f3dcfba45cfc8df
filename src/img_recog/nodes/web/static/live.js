// The tab with charts, the map and driving.
'use strict';

(() => {
  const HISTORY_S = 20;
  const DRIVE_PERIOD_MS = 100;
  const PLOT_TURNS = 3;           // a chart takes ten times as long as the map
  const MAP = 'canvas.map[data-event=pose]';
  const PATH_POINTS = 4000;
  const MAP_LINES = 12;           // of its grid, in each direction
  const LABELS_PX = 46;           // the width of a label of it
  const KNOB_PX = 40;             // how far the knob of the joystick moves
  const KEYS = {
    w: [1, 0], arrowup: [1, 0], x: [-1, 0], arrowdown: [-1, 0],
    a: [0, 1], arrowleft: [0, 1], d: [0, -1], arrowright: [0, -1], s: [0, 0],
  };
  // of colors with these names; readable on a light and on a dark card
  const LINES = { blue: '#4f7df3', red: '#e5484d', green: '#30a46c', yellow: '#d9a800',
    orange: '#f2751a', purple: '#8e4ec6', pink: '#d6409f' };
  const COMPACT = new Intl.NumberFormat('en', { notation: 'compact' });
  const { all, css, mapping, send, show, text, visible } = page;
  const { line } = mapping;
  const state = { areas: [], asked: [], driven: [], path: [], colors: [] };
  let turn = 0;

  // ---- measurements
  function reset() {
    Object.assign(state, { areas: [], asked: [], driven: [], path: [] });
  }

  function measure(measured) {
    for (const kind of ['areas', 'asked', 'driven']) {
      if (measured[kind]) state[kind].push(...measured[kind]);
    }
    for (const kind of ['pose', 'scan', 'outlines', 'colors', 'factor', 'robots']) {
      if (measured[kind] !== undefined) state[kind] = measured[kind];
    }
    if (measured.busy) state.busyUntil = Date.now() + 2000;
    if (measured.path) state.path = [...state.path, ...measured.path].slice(-PATH_POINTS);
    if (measured.factor !== undefined) {
      const { factor } = measured;
      show('[data-bind=factor]', factor === null ? '' : factor ? factor.toFixed(2)
        : text('paused'));
    }
    if (measured.pose) {
      const [x, y, yaw] = measured.pose;
      show('[data-bind=pose]', `${text('position')}: x ${x.toFixed(2)} m, y ${y.toFixed(2)} m; `
        + `${text('heading')}: ${Math.round(yaw * 180 / Math.PI) + 0}°`);
    }
  }

  // ---- charts, ECharts of NiceGUI
  function chart(name) {
    const element = document.querySelector(`[data-chart=${name}]`);
    if (!element || !element.offsetParent || typeof getElement !== 'function') return null;
    const component = getElement(Number(element.id.slice(1)));
    return component && component.chart ? component.chart : null;
  }

  function latest(series) {
    return series.length ? series[series.length - 1][0] : 0;
  }

  function plot() {
    const now = Math.max(latest(state.areas), latest(state.asked), latest(state.driven));
    for (const kind of ['areas', 'asked', 'driven']) {
      const first = state[kind].findIndex((each) => each[0] >= now - HISTORY_S);
      state[kind].splice(0, first < 0 ? state[kind].length : first);
    }
    const column = (series, index) => series.map((each) => [each[0] - now, each[index]]);
    const areas = chart('areas');
    if (areas) {
      fitLegend(areas, state.colors);
      const formatter = (px) => (px > 1 ? COMPACT.format(px) : '0');
      areas.setOption({ yAxis: { axisLabel: { formatter } }, series: state.colors.map(
        (name, index) => ({ name, type: 'line', showSymbol: false, animation: false,
          color: LINES[name], markLine: limitLine(name),
          data: column(state.areas, index + 1).map(([time, px]) => [time, atLeast1(px)]) })) });
    }
    const speeds = chart('speeds');
    if (speeds) {
      const [asked, driven] = [column(state.asked, 1), column(state.driven, 1)];
      const cut = cutOff(asked, driven);
      const axis = { min: cut.low, max: cut.high, interval: cut.interval };
      speeds.setOption({ yAxis: { ...axis, axisLabel: { formatter: short } }, series: [
        { id: 'asked', name: text('asked') + cut.note, step: 'end', data: cut.points },
        { id: 'driven', name: text('driven'), data: driven },
      ].map((each) => ({ type: 'line', showSymbol: false, animation: false, ...each })) });
    }
  }

  const short = (value) => String(Number(value.toPrecision(3)));
  const atLeast1 = (value) => Math.max(1, value);         // a logarithmic axis has no 0

  // commands far above what is driven would make its line flat: they end at the edge of the chart
  function cutOff(asked, driven) {
    const values = asked.map((each) => each[1] || 0);
    const [least, most] = [Math.min(0, ...values), Math.max(0, ...values)];
    const edge = roundUp(1.3 * Math.max(0.2, ...driven.map((each) => Math.abs(each[1]))),
      [1, 2, 3, 5, 10]);
    if (most <= edge && least >= -edge) {
      return { points: asked, low: null, high: null, interval: null, note: '' };
    }
    const speeds = [...values, ...driven.map((each) => each[1])];
    return { points: asked.map(([time, value]) => [time,
      value === null ? null : Math.max(-edge, Math.min(edge, value))]),
      low: Math.min(...speeds) < 0 ? -edge : 0, high: Math.max(...speeds) > 0 ? edge : 0,
      interval: edge / 2,
      note: text('cut_off').replace('{}', short(least)).replace('{}', short(most)) };
  }

  // the least of these factors times a power of ten that is not less than a value
  function roundUp(value, factors) {
    const power = 10 ** Math.floor(Math.log10(value));
    return power * factors.find((each) => each * power >= value);
  }

  // room for all rows of the legend; sizes in pixels, as ECharts has them
  const ruler = document.createElement('canvas').getContext('2d');
  ruler.font = '12px sans-serif';
  function fitLegend(component, names) {
    let [rows, x] = [1, 0];
    for (const name of names) {
      const width = 25 + 5 + ruler.measureText(name).width + 10;
      if (x && x + width > component.getWidth() - 10) [rows, x] = [rows + 1, 0];
      x += width;
    }
    if (component.legendRows === rows) return;
    component.legendRows = rows;
    component.setOption({ grid: { top: 26 + 20 * (rows - 1) } });
    component.getDom().style.height = `${150 + 20 * (rows - 1)}px`;
    component.resize();
  }

  function limitLine(name) {
    const limit = (window.limits || {})[name];
    return limit === undefined ? { data: [] } : { silent: true, symbol: 'none', animation: false,
      label: { show: false }, lineStyle: { type: 'dashed' }, data: [{ yAxis: atLeast1(limit) }] };
  }

  // ---- the map
  function pointsInMap() {
    // of the path, what came after the robot was moved: it may have been far away
    const points = [...(state.outlines || []).flat(),
      ...state.path.slice(state.path.lastIndexOf(null) + 1),
      ...Object.values(state.robots || {})];
    if (state.pose) points.push(state.pose);
    return points;
  }

  function drawMap(canvas) {
    const drawing = mapping.begin(canvas, pointsInMap(), 1.06, LABELS_PX);
    if (!drawing) return;
    canvas.heading = () => (state.pose ? state.pose[2] : 0);
    const { context, at, side } = drawing;
    const [x0, y0, size] = canvas.extent;
    // a grid of whole meters; its labels stand beside what is in the world
    const step = Math.max(1, roundUp(size / MAP_LINES, [1, 2, 5, 10]));
    const labels = [];
    context.strokeStyle = css('--soft');
    context.globalAlpha = 0.6;
    for (let m = Math.ceil(x0 / step) * step; m < x0 + size; m += step) {
      line(context, [at([m, y0]), at([m, y0 + size])]);
      const y = at([m, y0])[1];       // the corner has those of the other axis
      if (y > 14 * devicePixelRatio && y < side - 20 * devicePixelRatio) {
        labels.push([`x ${m} m`, 3, y - 3]);
      }
    }
    let end = 0;
    for (let m = Math.floor((y0 + size) / step) * step; m > y0; m -= step) {
      line(context, [at([x0, m]), at([x0 + size, m])]);
      const [label, x] = [`y ${m} m`, at([x0, m])[0] + 3];
      if (x < end) continue;
      labels.push([label, x, side - 4]);
      end = x + context.measureText(label).width + 3;
    }
    context.globalAlpha = 1;
    mapping.drawOutlines(drawing, state.outlines || [], css('--line'), css('--soft'));
    context.fillStyle = css('--ink');
    for (const label of labels) {
      if (label[1] + context.measureText(label[0]).width < side) context.fillText(...label);
    }
    context.strokeStyle = '#2563eb';
    context.lineWidth = 2 * devicePixelRatio;
    let part = [];
    for (const point of [...state.path, null]) {
      if (point) {
        part.push(point);
      } else {        // the robot was moved
        line(context, part.map(at));
        part = [];
      }
    }
    const others = Object.entries(state.robots || {}).filter(([name]) => name !== window.robot);
    for (const [, place] of others) {
      mapping.drawRobot(drawing, place, '#9ca3af', 0.8);
    }
    context.fillStyle = css('--ink');
    const gap = mapping.robotSize(drawing);
    const names = others.map(([name, place]) => [
      name, at(place), context.measureText(name).width, gap]);
    const robots = [...names.map(([, place]) => [...place, 0.8 * gap]),
      ...(state.pose ? [[...at(state.pose), gap]] : [])];
    for (const [name, x, y] of mapping.placeLabels(names, side, robots)) {
      context.fillText(name, x, y);
    }
    if (!state.pose) return;
    if (state.scan) mapping.drawScan(drawing, state.scan, state.scan.pose || state.pose);
    mapping.drawRobot(drawing, state.pose, '#16a34a');
    mapping.drawTarget(canvas, drawing);
  }

  // ---- driving
  const held = new Map();         // a key or a pointer, and its direction

  function driven() {
    const sum = [...held.values()].reduce((a, b) => [a[0] + b[0], a[1] + b[1]], [0, 0]);
    return sum.map((each) => Math.max(-1, Math.min(1, each)));
  }

  const isBusy = () => Date.now() < (state.busyUntil || 0);

  function mark() {
    const [forward, left] = isBusy() ? [0, 0] : driven();
    for (const knob of all('[data-stick] .knob')) {
      knob.style.transform = `translate(${-left * KNOB_PX}px, ${-forward * KNOB_PX}px)`;
    }
    const directions = new Set([...held.values()].map(String));
    for (const button of all('[data-drive]')) {
      button.classList.toggle('held', directions.has(button.dataset.drive) && !isBusy());
    }
  }

  function hold(source, direction) {
    if (!direction[0] && !direction[1]) held.clear();       // stop, whatever else is held
    held.set(source, direction);
    send({ drive: driven() });
    mark();
  }

  function letGo(source) {
    if (!held.delete(source)) return;
    send({ drive: held.size ? driven() : null });
    mark();
  }

  function release() {
    if (held.size) { held.clear(); send({ drive: null }); mark(); }
  }

  setInterval(() => { if (held.size) send({ drive: driven() }); }, DRIVE_PERIOD_MS);
  const isTyping = (target) => target.closest
    && target.closest('input, textarea, select, [role=slider], [contenteditable]');
  // The place of a key: its letter changes when a modifier is pressed before it is let go.
  const place = (event) => event.code || event.key.toLowerCase();
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) {
      release();      // some systems do not tell any more when another key is let go
      return;
    }
    const direction = KEYS[event.key.toLowerCase()];
    if (!direction || isTyping(event.target) || !document.querySelector('[data-drive]')) return;
    event.preventDefault();
    if (!event.repeat) hold(place(event), direction);
  });
  document.addEventListener('keyup', (event) => letGo(place(event)), true);
  window.addEventListener('blur', release);
  // else the tab that was clicked takes the keys left and right
  document.addEventListener('click', (event) => {
    const tab = event.target.closest && event.target.closest('[role=tab]');
    if (tab && event.detail && tab.contains(document.activeElement)) document.activeElement.blur();
  });
  document.addEventListener('pointerdown', (event) => {
    const button = event.target.closest && event.target.closest('[data-drive]');
    if (!button) return;
    hold(event.pointerId, button.dataset.drive.split(',').map(Number));
  });
  // the joystick: forward and left, each from -1 to 1, at most 1 together
  const stickAt = ({ target }) => target.closest && target.closest('[data-stick]');
  function tilt(stick, event) {
    const box = stick.getBoundingClientRect();
    const forward = 1 - 2 * (event.clientY - box.top) / box.height;
    const left = 1 - 2 * (event.clientX - box.left) / box.width;
    const far = Math.max(1, Math.hypot(forward, left));
    return [forward / far, left / far];
  }
  document.addEventListener('pointerdown', (event) => {
    const stick = stickAt(event);
    if (!stick) return;
    stick.setPointerCapture(event.pointerId);
    hold(event.pointerId, tilt(stick, event));
  });
  document.addEventListener('pointermove', (event) => {
    const stick = stickAt(event);
    if (!stick || !held.has(event.pointerId)) return;
    held.set(event.pointerId, tilt(stick, event));
    mark();
  });
  for (const name of ['pointerup', 'pointercancel']) {
    document.addEventListener(name, (event) => letGo(event.pointerId));
  }
  document.addEventListener('contextmenu', (event) => {
    if (event.target.closest && event.target.closest('[data-drive], [data-stick]')) {
      event.preventDefault();
    }
  });
  // with the keyboard alone: a button drives as long as Enter or Space is held on it; before the
  // buttons of Quasar, which stop these events
  document.addEventListener('keydown', (event) => {
    const button = event.target.closest && event.target.closest('[data-drive]');
    if (button && (event.key === 'Enter' || event.key === ' ') && !event.repeat) {
      hold(place(event), button.dataset.drive.split(',').map(Number));
    }
  }, true);

  page.add({
    selector: MAP,
    measured: measure,
    reset,
    pause: release,     // who was stopped by another page must not drive with the next connection
    resume: () => state.path.push(null),        // what came meanwhile is not known
    draw: () => {
      show('[data-bind=busy]', isBusy() ? text('busy') : '');
      mark();
      for (const element of visible) if (element.matches(MAP)) drawMap(element);
      turn += 1;
      if (turn % PLOT_TURNS === 0) plot();
    },
  });
})();
