// Shows what the server sends over one WebSocket, and sends what the visitor holds and points at.
'use strict';

(() => {
  const HISTORY_S = 20;
  const DRIVE_PERIOD_MS = 100;
  const RETRY_MS = 1000;
  const MAX_LOG = 500;
  const PATH_POINTS = 4000;
  const MAP_LINES = 12;           // of its grid, in each direction
  const MAX_PICTURES = 32;        // that the server sends
  const STALE_MS = 5000;          // of the state of a node, which comes once a second
  const OLD_MS = 2000;            // of a picture
  const LEVELS = ['debug', 'info', 'warn', 'error', 'fatal'];
  const KEYS = {
    w: [1, 0], arrowup: [1, 0], x: [-1, 0], arrowdown: [-1, 0],
    a: [0, 1], arrowleft: [0, 1], d: [0, -1], arrowright: [0, -1], s: [0, 0],
  };
  // of colors with these names; readable on a light and on a dark card
  const LINES = { blue: '#4f7df3', red: '#e5484d', green: '#30a46c', yellow: '#d9a800',
    orange: '#f2751a', purple: '#8e4ec6', pink: '#d6409f' };
  const decoder = new TextDecoder();
  const all = (selector) => [...document.querySelectorAll(selector)];
  const text = (key) => (window.texts || {})[key] || key;
  const css = (name) => getComputedStyle(document.body).getPropertyValue(name).trim();

  // ---- what is shown
  const visible = new Set();
  const state = { areas: [], asked: [], driven: [], path: [], log: [], nodes: {}, colors: [],
    lines: 0 };
  const observer = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (entry.isIntersecting) visible.add(entry.target); else visible.delete(entry.target);
      if (entry.isIntersecting && entry.target.matches('[data-graph]')) loadGraph(entry.target);
    }
    look();
  });
  const observed = new WeakSet();
  // elements of the page come and go with its tabs
  new MutationObserver(() => adopt()).observe(document.documentElement,
    { childList: true, subtree: true });

  function adopt() {
    for (const element of all('canvas[data-picture], canvas.map, [data-graph]')) {
      if (!observed.has(element)) { observed.add(element); observer.observe(element); }
    }
    for (const element of visible) {
      if (!element.isConnected) { visible.delete(element); look(); }
    }
    // a tab that was not open has missed lines
    for (const box of all('[data-log]')) if (box.lines !== state.lines) fillLog(box);
  }

  // ---- the connection
  let socket = null;
  let looked = '';

  function connect() {
    const scheme = location.protocol === 'https:' ? 'wss://' : 'ws://';
    socket = new WebSocket(`${scheme}${location.host}/live?robot=`
      + encodeURIComponent(window.robot || ''));
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => {
      looked = '';
      reset();
      look();
      send({ ready: 1 });
    };
    socket.onmessage = async (event) => {
      try { await take(event.data); } finally { send({ ready: 1 }); }
    };
    socket.onclose = () => {
      release();      // who was stopped by another page must not drive with the next connection
      setTimeout(connect, RETRY_MS);
    };
  }

  function send(message) {
    if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
  }

  function look() {
    const names = document.hidden ? null
      : [...new Set([...visible].map((each) => each.dataset.picture).filter(Boolean))].sort()
        .slice(0, MAX_PICTURES);
    const wanted = JSON.stringify(names);
    if (wanted === looked) return;
    if (looked === 'null') state.path.push(null);       // what came meanwhile is not known
    looked = wanted;
    send({ look: names });
  }
  document.addEventListener('visibilitychange', () => { release(); look(); });

  async function take(buffer) {
    const length = new DataView(buffer).getUint32(0);
    const news = JSON.parse(decoder.decode(new Uint8Array(buffer, 4, length)));
    let start = 4 + length;
    const drawn = [];
    for (const [name, size] of news.pictures) {
      drawn.push(draw(name, new Blob([new Uint8Array(buffer, start, size)],
        { type: 'image/jpeg' })));
      start += size;
    }
    measure(news.measured);
    await Promise.all(drawn);
  }

  async function draw(name, blob) {
    const bitmap = await createImageBitmap(blob);
    for (const canvas of all('canvas[data-picture]')) {
      if (canvas.dataset.picture !== name || !visible.has(canvas)) continue;
      if (canvas.width !== bitmap.width || canvas.height !== bitmap.height) {
        canvas.width = bitmap.width;
        canvas.height = bitmap.height;
        canvas.parentElement.style.aspectRatio = bitmap.width + ' / ' + bitmap.height;
      }
      canvas.getContext('2d').drawImage(bitmap, 0, 0);
      canvas.drawn = performance.now();
      canvas.parentElement.classList.add('there');
    }
    bitmap.close();
  }

  function showAge(canvas) {
    const age = performance.now() - canvas.drawn;       // NaN before the first image
    canvas.parentElement.querySelector('.age').textContent = age > OLD_MS
      ? text('age').replace('{}', Math.round(age / 1000)) : '';
  }

  // ---- measurements
  function reset() {
    Object.assign(state, { areas: [], asked: [], driven: [], path: [], log: [], nodes: {} });
    all('[data-log]').forEach(fillLog);
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
    const nodes = Object.entries(measured).filter(([kind]) => kind.startsWith('node '));
    // by the clock of the server: a new page gets old states too
    const now = Math.max(...nodes.map(([, node]) => node.time_s));
    for (const [kind, node] of nodes) {
      state.nodes[kind.slice(5)] = { ...node,
        heard: performance.now() - 1000 * (now - node.time_s) };
    }
    if (measured.log) log(measured.log);
  }

  function show(selector, value) {
    for (const element of all(selector)) {
      if (element.textContent !== value) element.textContent = value;
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
      areas.setOption({ series: state.colors.map((name, index) => ({
        name, type: 'line', showSymbol: false, animation: false, color: LINES[name],
        data: column(state.areas, index + 1), markLine: limitLine(name) })) });
    }
    const speeds = chart('speeds');
    if (speeds) {
      speeds.setOption({ series: [['asked', 'asked'], ['driven', 'driven']].map(([kind, key]) => ({
        name: text(key), type: 'line', showSymbol: false, animation: false,
        step: kind === 'asked' ? 'end' : false, data: column(state[kind], 1) })) });
    }
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
      label: { show: false }, lineStyle: { type: 'dashed' }, data: [{ yAxis: limit }] };
  }

  // ---- the map
  function bounds() {
    // of the path, what came after the robot was moved: it may have been far away
    const points = [...(state.outlines || []).flat(),
      ...state.path.slice(state.path.lastIndexOf(null) + 1),
      ...Object.values(state.robots || {})];
    if (state.pose) points.push(state.pose);
    if (!points.length) return [-2.5, -2.5, 5];
    const xs = points.map((each) => each[0]);
    const ys = points.map((each) => each[1]);
    const size = Math.max(Math.max(...xs) - Math.min(...xs), Math.max(...ys) - Math.min(...ys), 2)
      * 1.12;
    return [(Math.max(...xs) + Math.min(...xs) - size) / 2,
      (Math.max(...ys) + Math.min(...ys) - size) / 2, size];
  }

  function toMap(canvas, event) {
    const box = canvas.getBoundingClientRect();
    const [x, y, size] = canvas.extent || bounds();
    return [x + (event.clientX - box.left) / box.width * size,
      y + (box.bottom - event.clientY) / box.height * size];
  }

  function drawMap(canvas) {
    const side = Math.round(canvas.clientWidth * devicePixelRatio);
    if (!side) return;
    if (canvas.width !== side) { canvas.width = side; canvas.height = side; }
    const [x0, y0, size] = canvas.extent = bounds();
    const scale = side / size;
    const at = ([x, y]) => [(x - x0) * scale, side - (y - y0) * scale];
    const context = canvas.getContext('2d');
    context.clearRect(0, 0, side, side);
    context.lineWidth = devicePixelRatio;
    context.font = `${11 * devicePixelRatio}px sans-serif`;
    // a grid of whole meters; its labels stand on what is in the world
    const power = 10 ** Math.floor(Math.log10(size / MAP_LINES));
    const step = Math.max(1, [1, 2, 5, 10].map((each) => each * power).find(
      (each) => size / each <= MAP_LINES));
    const labels = [];
    context.strokeStyle = css('--soft');
    context.globalAlpha = 0.6;
    for (let m = Math.ceil(x0 / step) * step; m < x0 + size; m += step) {
      line(context, [at([m, y0]), at([m, y0 + size])]);
      labels.push([`${m} m`, at([m, y0])[0] + 3, side - 4]);
    }
    for (let m = Math.ceil(y0 / step) * step; m < y0 + size; m += step) {
      line(context, [at([x0, m]), at([x0 + size, m])]);
      const y = at([x0, m])[1];       // the corner has those of the other axis
      if (y < side - 20 * devicePixelRatio) labels.push([`${m} m`, 3, y - 3]);
    }
    context.globalAlpha = 1;
    context.strokeStyle = css('--line');
    context.fillStyle = css('--soft');
    for (const outline of state.outlines || []) {
      line(context, [...outline, outline[0]].map(at));
      context.fill();
    }
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
    for (const [name, place] of Object.entries(state.robots || {})) {
      if (name === window.robot) continue;
      arrow(context, at(place), place[2], Math.max(8 * devicePixelRatio, 0.12 * scale), '#9ca3af');
      context.fillStyle = css('--ink');
      const width = context.measureText(name).width + 10 * devicePixelRatio;
      context.fillText(name, Math.min(at(place)[0] + 10 * devicePixelRatio, side - width),
        at(place)[1]);
    }
    if (!state.pose) return;
    const [x, y, yaw] = state.pose;
    if (state.scan) {
      const [scanX, scanY, scanYaw] = state.scan.pose || state.pose;
      context.fillStyle = '#dc2626';
      const dot = 2 * devicePixelRatio;
      state.scan.ranges.forEach((range, index) => {
        if (range === null) return;
        const angle = scanYaw + state.scan.angle_min + index * state.scan.angle_increment;
        const [px, py] = at([scanX + range * Math.cos(angle), scanY + range * Math.sin(angle)]);
        context.fillRect(px - dot / 2, py - dot / 2, dot, dot);
      });
    }
    arrow(context, at([x, y]), yaw, Math.max(10 * devicePixelRatio, 0.15 * scale), '#16a34a');
    if (canvas.target) {
      arrow(context, at(canvas.target), canvas.target[2], Math.max(10 * devicePixelRatio,
        0.15 * scale), '#f59e0b');
    }
  }

  function line(context, points) {
    context.beginPath();
    points.forEach(([x, y], index) => (index ? context.lineTo(x, y) : context.moveTo(x, y)));
    context.stroke();
  }

  function arrow(context, [x, y], yaw, size, color) {
    context.save();
    context.translate(x, y);
    context.rotate(-yaw);
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

  document.addEventListener('pointerdown', (event) => {
    const canvas = event.target.closest && event.target.closest('canvas.map');
    if (!canvas || !event.isPrimary || event.button) return;
    event.preventDefault();
    canvas.setPointerCapture(event.pointerId);
    canvas.target = [...toMap(canvas, event), state.pose ? state.pose[2] : 0];
  });
  document.addEventListener('pointermove', (event) => {
    const canvas = event.target;
    if (!canvas.target || !canvas.hasPointerCapture || !canvas.hasPointerCapture(event.pointerId)) {
      return;
    }
    const [x, y] = toMap(canvas, event);
    if (Math.hypot(x - canvas.target[0], y - canvas.target[1]) > 0.1) {
      canvas.target[2] = Math.atan2(y - canvas.target[1], x - canvas.target[0]);
    }
  });
  document.addEventListener('pointerup', (event) => {
    const canvas = event.target;
    if (!canvas.target) return;
    emitEvent('pose', { x: canvas.target[0], y: canvas.target[1], yaw: canvas.target[2] });
    canvas.target = null;
  });
  document.addEventListener('pointercancel', (event) => { event.target.target = null; });
  document.addEventListener('click', (event) => {
    const canvas = event.target.closest && event.target.closest('canvas.pick');
    if (!canvas) return;
    const box = canvas.getBoundingClientRect();
    emitEvent('pick', { topic: canvas.dataset.picture, x: (event.clientX - box.left) / box.width,
      y: (event.clientY - box.top) / box.height });
  });

  // ---- driving
  const held = new Map();         // a key or a pointer, and its direction

  function driven() {
    const sum = [...held.values()].reduce((a, b) => [a[0] + b[0], a[1] + b[1]], [0, 0]);
    return sum.map((each) => Math.max(-1, Math.min(1, each)));
  }

  const isBusy = () => Date.now() < (state.busyUntil || 0);

  function mark() {
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
  for (const name of ['pointerup', 'pointercancel']) {
    document.addEventListener(name, (event) => letGo(event.pointerId));
  }
  document.addEventListener('contextmenu', (event) => {
    if (event.target.closest && event.target.closest('[data-drive]')) event.preventDefault();
  });
  // with the keyboard alone: a button drives as long as Enter or Space is held on it; before the
  // buttons of Quasar, which stop these events
  document.addEventListener('keydown', (event) => {
    const button = event.target.closest && event.target.closest('[data-drive]');
    if (button && (event.key === 'Enter' || event.key === ' ') && !event.repeat) {
      hold(place(event), button.dataset.drive.split(',').map(Number));
    }
  }, true);

  // ---- log and nodes
  function log(entries) {
    const known = state.lines;
    state.log.push(...entries);
    state.log.splice(0, Math.max(0, state.log.length - MAX_LOG));
    state.lines += entries.length;
    for (const box of all('[data-log]')) {
      if (box.lines !== known) { fillLog(box); continue; }
      box.lines = state.lines;
      const isAtEnd = box.scrollHeight - box.scrollTop - box.clientHeight < 30;
      box.append(...entries.map(logLine));
      while (box.childElementCount > MAX_LOG) box.firstElementChild.remove();
      filterLog(box);
      if (isAtEnd) box.scrollTop = box.scrollHeight;
    }
  }

  function fillLog(box) {
    box.lines = state.lines;
    box.replaceChildren(...state.log.map(logLine));
    filterLog(box);
    box.scrollTop = box.scrollHeight;
  }

  function logLine([time, level, node, message]) {
    const row = document.createElement('div');
    row.dataset.level = level;
    const name = document.createElement('span');
    name.className = `level level-${level}`;
    name.textContent = level.toUpperCase();
    row.append(name, ` ${time.toFixed(2)} s ${node}: ${message}`);
    return row;
  }

  function filterLog(box) {
    const lowest = LEVELS.indexOf(box.dataset.log);
    for (const row of box.children) row.hidden = LEVELS.indexOf(row.dataset.level) < lowest;
  }
  window.filterLog = (level) => all('[data-log]').forEach((box) => {
    box.dataset.log = level;
    fillLog(box);
  });

  function listNodes() {
    const levels = ['ok', 'warn', 'error', 'stale'];
    for (const body of all('[data-nodes]')) {
      body.replaceChildren(...Object.keys(state.nodes).sort().map((name) => {
        const node = state.nodes[name];
        const rates = node.values.filter(([key]) => key.endsWith('(Hz)'))
          .map(([key, value]) => `${key.slice(0, -5)} ${value} Hz`).join(', ');
        const row = document.createElement('tr');
        const isStale = performance.now() - node.heard > STALE_MS;
        const level = isStale ? 'stale' : levels[node.level] || 'error';
        const told = [level.toUpperCase(), node.message].filter(Boolean).join(': ');
        for (const value of [node.name, told, isStale ? '' : rates]) {
          const cell = document.createElement('td');
          cell.textContent = value;
          row.append(cell);
        }
        row.children[1].className = `level-${level}`;
        return row;
      }));
    }
  }

  // ---- the graph
  const loading = new Map();      // the images of graphs, and whether each is to be loaded again

  function loadGraph(image) {
    if (loading.has(image)) { loading.set(image, true); return; }
    loading.set(image, false);
    const next = new Image();
    const end = () => {
      const isOld = loading.get(image);
      loading.delete(image);
      if (isOld) loadGraph(image);
    };
    next.onload = () => { image.src = next.src; show('[data-bind=graph]', ''); end(); };
    next.onerror = async () => {
      try {
        const answer = await fetch(next.src);
        if (!answer.ok) show('[data-bind=graph]', await answer.text());
      } catch (error) { /* not connected, which the page says elsewhere */ }
      end();
    };
    next.src = `/graph.svg?dark=${document.body.classList.contains('body--dark') ? 1 : 0}`
      + `&leaves=${image.dataset.graph}&t=${Date.now()}`;
  }
  window.loadGraph = () => all('[data-graph]').forEach(loadGraph);

  setInterval(() => {
    if (document.hidden) return;
    show('[data-bind=connection]', text(
      socket && socket.readyState === WebSocket.OPEN ? 'connected' : 'disconnected'));
    show('[data-bind=busy]', isBusy() ? text('busy') : '');
    mark();
    for (const element of visible) if (element.matches('canvas.map')) drawMap(element);
    plot();
  }, 100);
  setInterval(() => {
    if (document.hidden) return;
    listNodes();
    for (const element of visible) if (element.matches('canvas[data-picture]')) showAge(element);
    for (const element of visible) {
      if (element.matches('[data-graph]') && !loading.has(element)) loadGraph(element);
    }
  }, 2000);
  document.addEventListener('DOMContentLoaded', () => {
    adopt();
    // NiceGUI's own, which is in the language of the server
    all('#popup > span').forEach((line, index) => {
      line.textContent = text(['connection_lost', 'reconnecting'][index]);
    });
  });
  connect();
})();
