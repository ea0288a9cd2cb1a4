component bristle_guard "adds a friction feedforward to the effort of a controller, with a ramp, a test effort and watchdogs that remove both";
pin in float reference "set point [machine unit]";
pin in float feedback "measured position [machine unit]";
pin in float loop "effort of the controller [effort unit]";
pin in float feed "effort of the feedforward [effort unit]";
pin out float total "effort to the amplifier [effort unit]";
pin in float gain = 0.0 "wanted gain of the feedforward, 0 to 1";
pin out float gain_now "present gain, behind the ramp";
pin in float offset = 0.0 "test effort [effort unit]";
pin in u32 alive "must change within patience cycles, unless keep is true";
pin in bit keep "true: the feedforward stays when the program ends";
pin in bit reset "true: clears a trip";
pin out bit ok = 1 "false: a watchdog tripped; connect it to what stops the motion";
pin out s32 why "1 following error, 2 effort, 3 travel, 4 no program alive, 5 feedforward not finite";
pin out u32 count "cycles";
param rw float max_error = 0.0 "[machine unit]";
param rw float max_effort = 0.0 "[effort unit]";
param rw float low = 0.0 "[machine unit]";
param rw float high = 0.0 "[machine unit]";
param rw float slew = 2.0 "ramp of the gain [1/s]";
param rw float clock = 1.0 "seconds of the axis in a second of the thread; tests only";
param rw u32 patience = 2000 "cycles without a sign of the program";
variable unsigned seen;
variable unsigned age;
function _ fp;
license "BSD";
;;
#include <rtapi_math.h>
FUNCTION(_) {
  double wish = gain < 0 ? 0 : gain > 1 ? 1 : gain, most = slew * period * 1e-9 * clock, given = feed;
  count++;
  if (alive != seen) { seen = alive; age = 0; } else if (age < 4000000000u) age++;
  if (reset) { ok = 1; why = 0; age = 0; }
  if (ok && !(fabs(reference - feedback) <= max_error)) { ok = 0; why = 1; }
  if (ok && !(fabs(total) <= max_effort)) { ok = 0; why = 2; }
  if (ok && !(feedback >= low && feedback <= high)) { ok = 0; why = 3; }
  if (ok && !keep && age > patience) { ok = 0; why = 4; }
  if (!(fabs(given) < 1e12)) { given = 0; ok = 0; why = 5; }
  if (!ok || !(wish <= 1)) wish = 0;
  gain_now += wish - gain_now > most ? most : wish - gain_now < -most ? -most : wish - gain_now;
  total = loop + gain_now * given + (ok ? offset : 0);
}
