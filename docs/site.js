// Tables that scroll take the focus, so that the keyboard scrolls them.
document$.subscribe(() => {
  for (const region of document.querySelectorAll(".md-typeset__scrollwrap")) region.tabIndex = 0;
});
