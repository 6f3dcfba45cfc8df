// The tab with the states of the nodes.
'use strict';

(() => {
  const STALE_MS = 5000;          // of the state of a node, which comes once a second
  const { all } = page;
  let states = {};

  function measure(measured) {
    const nodes = Object.entries(measured).filter(([kind]) => kind.startsWith('node '));
    // by the clock of the server: a new page gets old states too
    const now = Math.max(...nodes.map(([, node]) => node.time_s));
    for (const [kind, node] of nodes) {
      states[kind.slice(5)] = { ...node,
        heard: performance.now() - 1000 * (now - node.time_s) };
    }
  }

  function listNodes() {
    const levels = ['ok', 'warn', 'error', 'stale'];
    for (const body of all('[data-nodes]')) {
      body.replaceChildren(...Object.keys(states).sort().map((name) => {
        const node = states[name];
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

  page.add({ measured: measure, reset: () => { states = {}; }, refresh: listNodes });
})();
