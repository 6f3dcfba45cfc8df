// The tab with the log.
'use strict';

(() => {
  const MAX_LOG = 300;            // of each level
  const LEVELS = ['debug', 'info', 'warn', 'error', 'fatal'];
  const { all } = page;
  let lines = [];
  let count = 0;      // of all that came

  // the oldest of each level: many lines of one level remove none of another
  const tooMany = (entries, levelOf) => LEVELS.flatMap(
    (level) => entries.filter((each) => levelOf(each) === level).slice(0, -MAX_LOG));

  function log(entries) {
    const known = count;
    lines.push(...entries);
    const old = new Set(tooMany(lines, ([, level]) => level));
    lines = lines.filter((each) => !old.has(each));
    count += entries.length;
    for (const box of all('[data-log]')) {
      if (box.lines !== known) { fillLog(box); continue; }
      box.lines = count;
      const isAtEnd = box.scrollHeight - box.scrollTop - box.clientHeight < 30;
      box.append(...entries.map(logLine));
      tooMany([...box.children], (row) => row.dataset.level).forEach((row) => row.remove());
      filterLog(box);
      if (isAtEnd) box.scrollTop = box.scrollHeight;
    }
  }

  function fillLog(box) {
    box.lines = count;
    box.replaceChildren(...lines.map(logLine));
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

  page.add({
    measured: ({ log: entries }) => { if (entries) log(entries); },
    reset: () => {
      lines = [];
      all('[data-log]').forEach(fillLog);
    },
    // a tab that was not open has missed lines
    adopt: () => all('[data-log]').forEach((box) => { if (box.lines !== count) fillLog(box); }),
  });
})();
