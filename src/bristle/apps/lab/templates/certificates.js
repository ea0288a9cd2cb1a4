// Whether friction with these values drifts and closes its loops: the tests of `bristle check`, run with the module
// itself. The contact is moved so slowly that neither viscosity nor micro-damping shows.

const CREEP = 1e-15, LONGEST = 1e3, RESOLUTION = 200, SETTLED = 1e-3, MOST_STEPS = 20000; // [m/s or rad/s], [m or rad]
const RIPPLE = [0.3, 0.6], CYCLES = 100, DRIFT_ALLOWED = 1e-6, LOADED = 0.85, BACK = 0.5, GAP_ALLOWED = 1e-3;

// Numbers from one to another by equal factors.
function byFactors(first, last, count) {
  return Array.from({ length: count }, (_, i) => first * (last / first) ** (i / (count - 1)));
}

function moveTo(contact, place, to) {
  contact.advance(to, Math.abs(to - place) / CREEP);
  return to;
}

// The break-away force of one side; infinite if the force grows with the position without limit.
function slidToTheEnd(contact, side) {
  contact.begin();
  contact.advance(0, 1);
  let place = 0;
  for (const reach of byFactors(1e-12, LONGEST, 100)) place = moveTo(contact, place, side * reach);
  const before = contact.rest(side * 0, 0);
  moveTo(contact, place, 2 * place);
  const after = contact.rest(side * 0, 0);
  return Math.abs(after - before) <= SETTLED * Math.abs(after) ? after : side * Infinity;
}

// The break-away force, and the distance over which a virgin contact builds up half of it.
function holdingOf(contact) {
  const forward = slidToTheEnd(contact, 1), backward = slidToTheEnd(contact, -1), half = 0.5 * (forward - backward);
  const level = (share) => 0.5 * (forward + backward) + share * half;
  const holding = { half, level, breaksAway: half > 0 && half < Infinity, distance: 0 };
  contact.begin();
  contact.advance(0, 1);
  if (!holding.breaksAway || contact.rest(0, 0) >= level(0.5)) return holding;
  let place = 0;
  for (const reach of byFactors(1e-15, LONGEST, 400)) {
    place = moveTo(contact, place, reach);
    if (contact.rest(0, 0) >= level(0.5)) return { ...holding, distance: reach };
  }
  return holding;
}

// A virgin contact moved from force to force, or from position to position.
class Led {
  constructor(contact, holding) {
    Object.assign(this, { contact, step: holding.distance / RESOLUTION, place: 0, kept: contact.kept() });
    contact.begin();
    contact.advance(0, 1);
  }

  to(place) {
    const start = this.place, count = Math.ceil(Math.min(Math.max(Math.abs(place - start) / this.step, 1), MOST_STEPS));
    for (let k = 1; k <= count; k++) this.place = moveTo(this.contact, this.place, k < count ? start + (place - start) * (k / count) : place);
  }

  // False if the force is not reached.
  toForce(target) {
    const side = this.contact.rest(0, 0) < target ? 1 : this.contact.rest(-0, 0) > target ? -1 : 0;
    for (let k = 0; k < MOST_STEPS && side !== 0; k++) {
      const start = this.place, beyond = (place) => {
        this.place = moveTo(this.contact, start, place);
        return side * (this.contact.rest(side * 0, 0) - target) >= 0;
      };
      this.contact.kept(this.kept);
      if (!beyond(start + side * this.step)) continue;
      // The force lies within this step: find its position by bisection.
      let low = 0, high = this.step;
      for (let i = 0; i < 52; i++) {
        const middle = 0.5 * (low + high);
        this.contact.back(this.kept);
        if (beyond(start + side * middle)) high = middle; else low = middle;
      }
      this.contact.back(this.kept);
      beyond(start + side * high);
      return true;
    }
    return side === 0;
  }
}

// Drift in a cycle of a force below break-away, and the allowed drift.
function driftOf(contact, holding) {
  if (!holding.breaksAway) return null;
  if (holding.distance === 0) return { moved: 0, allowed: 0, passed: true };
  const led = new Led(contact, holding), [low, high] = RIPPLE.map(holding.level);
  if (!led.toForce(high)) return null;
  const allowed = DRIFT_ALLOWED * Math.abs(led.place);
  let moved = 0;
  for (let k = 0; k < CYCLES; k++) {
    const start = led.place, before = moved;
    led.toForce(low);
    led.toForce(high);
    moved = led.place - start;
    if (Math.abs(moved - before) <= 1e-5 * Math.abs(moved) || Math.abs(moved) <= 1e-3 * allowed) break;
  }
  return { moved, allowed, passed: Math.abs(moved) <= allowed };
}

// Missing force on return to the start of a loop, over break-away.
function closureOf(contact, holding) {
  if (!holding.breaksAway || holding.distance === 0) return null;
  const scout = new Led(contact, holding);
  if (!scout.toForce(holding.level(LOADED))) return null;
  const led = new Led(contact, holding), end = scout.place;
  led.to(end);
  const loaded = contact.rest(0, 0);
  led.to((1 - BACK) * end);
  led.to(end);
  const missing = (contact.rest(0, 0) - loaded) / holding.half;
  return { missing, passed: Math.abs(missing) <= GAP_ALLOWED };
}

// Both; null if a test does not apply.
function judged(contact) {
  contact.hold();
  const holding = holdingOf(contact);
  return { holding, drift: driftOf(contact, holding), closure: closureOf(contact, holding) };
}

// --- in words ----------------------------------------------------------------------------------------------------------

// Two lines: the property, whether it holds (null if not applicable), and the deviation.
function verdicts(model, { holding, drift, closure }) {
  const lines = [], say = (asked, passed, text) => lines.push({ asked, passed, text });
  const resting = holding.breaksAway ? "the friction does not reach the test force" : "no break-away force";
  if (!drift) say("Drift", null, `not applicable: ${resting}`);
  else if (drift.passed) say("Drift", true, "no drift under a force ripple");
  else say("Drift", false, `the contact drifts by ${told(Math.abs(drift.moved), model.units.position)} per cycle of a force between ${RIPPLE.join(" and ")} of the break-away force`);
  if (!closure) say("Closure", null, "not applicable: no force builds up over a distance");
  else if (closure.passed) say("Closure", true, "minor loops return to their initial force");
  else say("Closure", false, `on return, ${withDigits(100 * Math.abs(closure.missing), 3)} % of the break-away force is missing`);
  return lines;
}
