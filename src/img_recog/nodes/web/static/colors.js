// The tab with the bounds of the colors: marking objects in the camera picture.
//
// A click in it emits the event `mark` with x and y, dragging also width and height: shares of the
// picture. The server then has the picture held, with lines around what is marked.
'use strict';

(() => {
  const SVG = 'http://www.w3.org/2000/svg';
  const DRAG_PX = 6;
  let start = null;

  // over the picture, with both sides of length 1
  function overlay(canvas) {
    let svg = canvas.parentElement.querySelector('svg');
    if (!svg) {
      svg = document.createElementNS(SVG, 'svg');
      svg.setAttribute('viewBox', '0 0 1 1');
      svg.setAttribute('preserveAspectRatio', 'none');
      canvas.parentElement.append(svg);
    }
    return svg;
  }

  function line(canvas, corners, name) {
    const polygon = document.createElementNS(SVG, 'polygon');
    polygon.setAttribute('points', corners.join(' '));
    polygon.setAttribute('class', name);
    overlay(canvas).append(polygon);
  }

  function removeLines(canvas, name) {
    overlay(canvas).querySelectorAll('.' + name).forEach((each) => each.remove());
  }

  // null: the live picture is shown again
  window.holdPicture = async (jpeg, outlines) => {
    const bitmap = jpeg && await createImageBitmap(await (await fetch(
      'data:image/jpeg;base64,' + jpeg)).blob());
    for (const canvas of page.all('canvas.pick')) {
      canvas.isHeld = Boolean(jpeg);
      canvas.parentElement.classList.toggle('held', canvas.isHeld);
      removeLines(canvas, 'marked');
      if (jpeg) page.paint(canvas, bitmap);
      outlines.forEach((each) => line(canvas, each, 'marked'));
    }
  };

  // the rectangle from where the pointer was pressed to where it is: left, top, right, bottom
  function dragged(event) {
    const box = start.canvas.getBoundingClientRect();
    const share = (at, low, size) => Math.max(0, Math.min(1, (at - low) / size));
    const xs = [start.x, event.clientX].map((x) => share(x, box.left, box.width));
    const ys = [start.y, event.clientY].map((y) => share(y, box.top, box.height));
    return [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
  }

  const isDrag = (event) => Math.hypot(event.clientX - start.x, event.clientY - start.y) > DRAG_PX;

  document.addEventListener('pointerdown', (event) => {
    const canvas = event.target.closest && event.target.closest('canvas.pick');
    if (!canvas || !event.isPrimary || event.button) return;
    event.preventDefault();
    canvas.setPointerCapture(event.pointerId);
    start = { canvas, x: event.clientX, y: event.clientY };
  });
  document.addEventListener('pointermove', (event) => {
    if (!start) return;
    removeLines(start.canvas, 'dragged');
    if (!isDrag(event)) return;
    const [left, top, right, bottom] = dragged(event);
    line(start.canvas, [[left, top], [right, top], [right, bottom], [left, bottom]], 'dragged');
  });
  document.addEventListener('pointerup', (event) => {
    if (!start) return;
    removeLines(start.canvas, 'dragged');
    const [x, y, right, bottom] = dragged(event);
    emitEvent('mark', isDrag(event) ? { x, y, width: right - x, height: bottom - y } : { x, y });
    start = null;
  });
  document.addEventListener('pointercancel', () => {
    if (start) removeLines(start.canvas, 'dragged');
    start = null;
  });
})();
