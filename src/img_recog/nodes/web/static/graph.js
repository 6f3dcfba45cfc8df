// The tab with the graph of nodes and topics.
'use strict';

(() => {
  const { all, show, visible } = page;
  const TEXT_PX = 12;             // the least height of a text; graphviz writes 14 pt
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
    next.onload = () => {
      image.src = next.src;
      image.style.minWidth = `${Math.round(TEXT_PX / (14 * 96 / 72) * next.naturalWidth)}px`;
      show('[data-bind=graph]', '');
      end();
    };
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

  page.add({
    selector: '[data-graph]',
    appear: loadGraph,
    refresh: () => {
      for (const element of visible) {
        if (element.matches('[data-graph]') && !loading.has(element)) loadGraph(element);
      }
    },
  });
})();
