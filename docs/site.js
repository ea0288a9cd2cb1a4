// Tables and cells that scroll take the focus, so that the keyboard scrolls them.
document$.subscribe(() => {
  for (const region of document.querySelectorAll(".md-typeset__scrollwrap, .highlight-ipynb")) region.tabIndex = 0;
});
