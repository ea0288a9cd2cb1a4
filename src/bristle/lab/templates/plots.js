// The plots of the page: pointer, zoom and handles.

// The sample of the first curve at the pointer; without curves the place itself.
function pickIn(frame, px, py) {
  if (!frame.curves) return { x: frame.valueAt(px), up: frame.valueUp(py) };
  const [x, y] = frame.curves[0];
  let best = 0, least = Infinity;
  for (let k = 0; k < x.length; k++) {
    const away = (frame.across(x[k]) - px) ** 2 + (frame.up(y[k]) - py) ** 2;
    if (away < least) [best, least] = [k, away];
  }
  return { k: best, of: x.length };
}

function tellIn(frame, { k, of, x, up }) {
  const { x: { unit }, y: { unit: unitUp } } = frame.own;
  if (!frame.curves) return `${frame.x.word} ${told(x, unit)}, ${frame.y.word} ${told(up, unitUp)}.`;
  const texts = frame.curves.map(([xs, ys, colour, name]) => {
    const at = Math.round(k / (of - 1) * (xs.length - 1));
    frame.dot(xs[at], ys[at], colour, 4);
    return `${frame.curves.length > 1 ? `${name} ` : ""}${told(ys[at], unitUp)}`;
  }), first = frame.curves[0][0][Math.round(k / (of - 1) * (frame.curves[0][0].length - 1))];
  frame.upright(first, frame.theme.soft);
  return `At ${told(first, unit)}: ${texts.join(", ")}.`;
}

function shiftIn(frame, at, way) {
  if (!frame.curves) return { ...at, x: at.x + way * (frame.x.high - frame.x.low) / 100 };
  return { ...at, k: Math.max(0, Math.min(at.of - 1, at.k + way * Math.ceil(at.of / 400))) };
}

function pullBlock(distance) {
  if (distance === null) return keep();
  play(false);
  return moveBy(distance);
}

function plotOf(name, view, extra = {}) {
  const drawn = (canvas, seen) => {
    const frame = canvas.clientWidth ? view(lab, canvas, seen) : null;
    if (frame) placeHandles(name, frame);
    return frame;
  };
  return new Pointed(byId(name), byId(`${name}-reading`), newView(), { draw: drawn, pick: pickIn, shift: shiftIn, tell: tellIn, both: true, wheel: true, ...extra });
}

function newPlots() {
  return {
    loop: plotOf("loop", loopView, { pull: pullBlock }),
    speed: plotOf("speed", speedView),
    plane: plotOf("plane", (...all) => (lab.model.stack ? planeView : elementsView)(...all)),
    track: plotOf("track", trackView),
  };
}
