// What all tabs of the page share: the connection to the server, and the pictures.
//
// The script of a tab calls page.add with some of these functions:
//   measured(values)    something was measured
//   reset()             all measurements come again, with another connection
//   pause(), resume()   the page or the connection was left; the page is looked at again
//   draw(), refresh()   ten times a second, and every 2 s, while somebody looks
//   appear(element)     an element that `selector` matches has come into sight
//   adopt()             elements of the page came or went
'use strict';

(() => {
  const RETRY_MS = 1000;
  const MAX_PICTURES = 32;        // that the server sends
  const OLD_MS = 2000;            // of a picture
  const decoder = new TextDecoder();
  const tabs = [];
  const call = (name, ...values) => tabs.filter((tab) => tab[name]).forEach(
    (tab) => tab[name](...values));
  const add = (tab) => tabs.push(tab);
  const all = (selector) => [...document.querySelectorAll(selector)];
  const text = (key) => (window.texts || {})[key] || key;
  const css = (name) => getComputedStyle(document.body).getPropertyValue(name).trim();

  function show(selector, value) {
    for (const element of all(selector)) {
      if (element.textContent !== value) element.textContent = value;
    }
  }

  // ---- what is in sight
  const visible = new Set();
  const observer = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (!entry.isIntersecting) { visible.delete(entry.target); continue; }
      visible.add(entry.target);
      tabs.filter((tab) => tab.appear && entry.target.matches(tab.selector)).forEach(
        (tab) => tab.appear(entry.target));
    }
    look();
  });
  const observed = new WeakSet();
  // elements of the page come and go with its tabs
  new MutationObserver(() => adopt()).observe(document.documentElement,
    { childList: true, subtree: true });

  function adopt() {
    const selectors = ['canvas[data-picture]', ...tabs.map((tab) => tab.selector).filter(Boolean)];
    for (const element of all(selectors.join())) {
      if (!observed.has(element)) { observed.add(element); observer.observe(element); }
    }
    for (const element of visible) {
      if (!element.isConnected) { visible.delete(element); look(); }
    }
    call('adopt');
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
      call('reset');
      look();
      send({ ready: 1 });
    };
    socket.onmessage = async (event) => {
      try { await take(event.data); } finally { send({ ready: 1 }); }
    };
    socket.onclose = () => {
      call('pause');
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
    if (looked === 'null') call('resume');
    looked = wanted;
    send({ look: names });
  }
  document.addEventListener('visibilitychange', () => { call('pause'); look(); });

  async function take(buffer) {
    const length = new DataView(buffer).getUint32(0);
    const message = JSON.parse(decoder.decode(new Uint8Array(buffer, 4, length)));
    let start = 4 + length;
    const drawn = [];
    for (const [name, size] of message.pictures) {
      drawn.push(draw(name, new Blob([new Uint8Array(buffer, start, size)],
        { type: 'image/jpeg' })));
      start += size;
    }
    call('measured', message.measured);
    await Promise.all(drawn);
  }

  async function draw(name, blob) {
    const bitmap = await createImageBitmap(blob);
    for (const canvas of all('canvas[data-picture]')) {
      if (canvas.dataset.picture !== name || !visible.has(canvas) || canvas.isHeld) continue;
      paint(canvas, bitmap);
    }
    bitmap.close();
  }

  function paint(canvas, bitmap) {
    if (canvas.width !== bitmap.width || canvas.height !== bitmap.height) {
      canvas.width = bitmap.width;
      canvas.height = bitmap.height;
      canvas.parentElement.style.setProperty('--ratio', bitmap.width / bitmap.height);
    }
    canvas.getContext('2d').drawImage(bitmap, 0, 0);
    canvas.drawn = performance.now();
    canvas.parentElement.classList.add('there');
  }

  function showAge(canvas) {
    const age = performance.now() - canvas.drawn;       // NaN before the first image
    canvas.parentElement.querySelector('.age').textContent = age > OLD_MS && !canvas.isHeld
      ? text('age').replace('{}', Math.round(age / 1000)) : '';
  }

  // ---- a click shows a picture as large as the window; Escape or another click ends that
  function grow(picture) {
    all('.picture.grown').forEach((each) => each.classList.remove('grown'));
    if (picture) picture.classList.add('grown');
  }
  document.addEventListener('click', ({ target }) => {
    const picture = target.closest && target.closest('.picture');
    grow(picture && !picture.querySelector('.pick') && !picture.matches('.grown') && picture);
  });
  document.addEventListener('keydown', ({ key }) => { if (key === 'Escape') grow(null); });

  setInterval(() => {
    if (document.hidden) return;
    show('[data-bind=connection]', text(
      socket && socket.readyState === WebSocket.OPEN ? 'connected' : 'disconnected'));
    call('draw');
  }, 100);
  setInterval(() => {
    if (document.hidden) return;
    for (const element of visible) if (element.matches('canvas[data-picture]')) showAge(element);
    call('refresh');
  }, 2000);
  document.addEventListener('DOMContentLoaded', () => {
    adopt();
    // below it is what stays in sight; its height depends on the font and the width
    const header = document.querySelector('.q-header');
    new ResizeObserver(() => document.documentElement.style.setProperty(
      '--header', header.offsetHeight + 'px')).observe(header);
    // NiceGUI's own, which is in the language of the server
    all('#popup > span').forEach((line, index) => {
      line.textContent = text(['connection_lost', 'reconnecting'][index]);
    });
    connect();      // now, all scripts are there
  });
  window.page = { add, all, css, paint, send, show, text, visible };
})();
