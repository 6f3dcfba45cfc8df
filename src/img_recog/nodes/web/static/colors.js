// The tab with the bounds of the colors: a click in the camera image.
'use strict';

document.addEventListener('click', (event) => {
  const canvas = event.target.closest && event.target.closest('canvas.pick');
  if (!canvas) return;
  const box = canvas.getBoundingClientRect();
  emitEvent('pick', { topic: canvas.dataset.picture, x: (event.clientX - box.left) / box.width,
    y: (event.clientY - box.top) / box.height });
});
