// What the image in FIELD_BOX_IMAGE does on an RP2040; run by ./dev firmware.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { Box, MS, random, UNIQUE_ID } from "./box.js";
import { word } from "./codec.js";

const MOMENTS = Number(process.env.FRICTION_BENCH_BOX_MOMENTS ?? 200);
const SEED = Number(process.env.FRICTION_BENCH_BOX_SEED ?? 35000);

/** Asserts that nothing is missing between reports. */
function complete(reports) {
  for (let k = 1; k < reports.length; k++) {
    assert.equal(reports[k].number, (reports[k - 1].number + 1) & 0xffff, `report ${k}`);
    assert.ok(reports[k].us > reports[k - 1].us, `time of report ${k}`);
  }
}

const extremes = (values) => `${Math.min(...values).toFixed(3)} to ${Math.max(...values).toFixed(3)}`;

test("it says who it is, when its port is opened and when asked", () => {
  const box = new Box().open();
  const [first] = box.heard();
  const serial = Buffer.from(UNIQUE_ID).toString("hex").toUpperCase();
  assert.deepEqual(first, { kind: "identity", firmware: "0.1.0", serial, reportHz: 1953, bits: 24 });
  assert.equal(box.host.serial, serial);
  box.ask();
  box.run(2);
  assert.deepEqual(box.heard().filter((message) => message.kind === "identity"), [first]);
});

test("it reports each conversion, with the moment that it is of", (context) => {
  // Counts are the time in µs, so that a reading says when it was true.
  const box = new Box({ signal: (ns) => [Math.floor(ns / 1000), -Math.floor(ns / 1000)] }).open();
  box.run(100);
  box.heard();
  box.run(1000);
  const reports = box.reports();
  complete(reports);
  assert.ok(Math.abs(reports.length - 1e9 / 512e3) <= 1, `${reports.length} reports`);
  assert.ok(reports.every((report) => !report.silent && report.lateral === -report.normal));
  const late = reports.map((report) => report.us - report.normal);
  context.diagnostic(`stamped after the middle of the filter by ${extremes(late)} µs`);
  assert.ok(late.every((us) => us >= 0 && us <= 25));
});

test("the enable rises after off and on, and the heartbeat passes", () => {
  const box = new Box().open();
  assert.deepEqual(box.rises, { enable: 0, heartbeat: 0 }, "low from power on");
  box.drive(20);
  assert.equal(box.enabled, false, "on without off");
  box.run(1);
  assert.equal(box.reports().at(-1).stop, "not released");
  box.say(false);
  box.run(1);
  box.drive(0.5);
  assert.equal(box.enabled, true);
  const before = box.rises.heartbeat;
  box.drive(200);
  assert.equal(box.rises.heartbeat - before, 50);
  box.run(2);
  const last = box.reports().at(-1);
  assert.deepEqual([last.enable, last.heard, last.stop], [true, box.number, "none"]);
  box.say(false);
  box.run(1);
  assert.equal(box.enabled, false);
  assert.deepEqual(box.rises.enable, 1);
});

test(`it stops by itself: ${MOMENTS} random moments`, (context) => {
  const box = new Box().open();
  const draw = random(SEED);
  const took = { killed: [], frozen: [], unplugged: [] };
  for (let k = 0; k < MOMENTS; k++) {
    const kind = Object.keys(took)[Math.floor(3 * draw())];
    box.arm();
    box.drive(4 + 60 * draw());
    assert.equal(box.enabled, true, "while words come");
    // The last word is on the way for as long as a transaction takes; the box's clock runs from its end.
    box.run(draw() * 2);
    box.say(true, box.beat);
    const { chip, host } = box;
    chip.run(chip.now + MS, () => host.outbox.length === 0);
    const last = chip.now;
    if (kind === "killed") chip.after(draw() * 20 * MS, () => host.setOpen(false));
    else host.setReading(false);
    assert.ok(box.run(200, () => !box.enabled), `${kind}: the enable stays on`);
    const ms = (box.fellAt - last) / MS;
    took[kind].push(ms);
    assert.ok(ms >= 79.9 && ms <= 100, `${kind}: after ${ms} ms`);
    if (kind === "killed") {
      box.run(30);
      host.setOpen(true);
    } else host.setReading(true);
    if (kind === "frozen") {
      // It goes on, and does not know.
      box.drive(20);
      assert.equal(box.enabled, false, "of a bench that was frozen");
      assert.equal(box.reports().at(-1).stop, "silence");
    }
    box.run(5);
    box.heard();
  }
  for (const [kind, times] of Object.entries(took)) {
    if (times.length > 0) context.diagnostic(`${kind}, ${times.length} times: off after ${extremes(times)} ms`);
  }
});

test("the e-stop drops the enable at once, and it stays off", (context) => {
  const box = new Box().open();
  const draw = random(SEED);
  const took = [];
  for (let k = 0; k < 50; k++) {
    box.arm();
    box.drive(2 + 5 * draw());
    assert.equal(box.enabled, true);
    const opened = box.chip.now;
    box.input("e-stop", false);
    box.run(1);
    assert.equal(box.enabled, false);
    took.push((box.fellAt - opened) / 1000);
    box.input("e-stop", true);
    box.drive(10);
    assert.equal(box.enabled, false, "after it was closed again");
    const last = box.reports().at(-1);
    assert.deepEqual([last.stop, last.estopClosed], ["estop", true]);
  }
  context.diagnostic(`off after ${extremes(took)} µs`);
  assert.ok(Math.max(...took) < 100);
  box.input("e-stop", false);
  box.arm();
  box.run(2);
  assert.equal(box.enabled, false, "with the loop open");
  assert.equal(box.reports().at(-1).estopClosed, false);
});

test("contacts are reported", () => {
  const box = new Box().open();
  const contacts = () => {
    box.run(3);
    const { estopClosed, button, deadMan } = box.reports().at(-1);
    return [estopClosed, button, deadMan];
  };
  assert.deepEqual(contacts(), [true, false, false]);
  box.input("button", true);
  assert.deepEqual(contacts(), [true, true, false]);
  box.input("button", false);
  box.input("dead-man switch", true);
  assert.deepEqual(contacts(), [true, false, true]);
});

test("every edge of the encoder counts, as fast as it comes", () => {
  const box = new Box().open();
  const draw = random(SEED);
  box.arm();
  // 10 million counts a second is 250 m/s at 25 µm a count.
  const moves = [
    [100_000, 100, () => true],
    [60_000, 100, () => false],
    [50_000, 100, () => draw() < 0.5],
    [20_000, 1_000, () => draw() < 0.9],
    [200, 1_000_000, () => draw() < 0.2],
  ];
  box.run(3);
  const origin = box.reports().at(-1).position - box.count;
  for (const [steps, ns, up] of moves) {
    let left = steps;
    const next = () => {
      box.step(up());
      if (--left > 0) box.chip.after(ns, next);
    };
    box.chip.after(ns, next);
    while (left > 0) box.drive(2);
    box.drive(4);
    assert.equal(box.reports().at(-1).position - origin, box.count);
  }
  assert.equal(box.enabled, true, "meanwhile");
});

test("a position is of the moment of its force", (context) => {
  const box = new Box().open();
  // One count a microsecond.
  const begin = box.chip.now + 1000;
  const next = () => {
    box.step(true);
    box.chip.after(1000, next);
  };
  box.chip.after(1000, next);
  box.run(50);
  box.heard();
  box.run(100);
  const apart = box.reports().map(({ us, position }) => us - begin / 1000 - position);
  context.diagnostic(`stamped after the count by ${extremes(apart)} µs`);
  assert.ok(apart.every((us) => us >= -2 && us <= 5), extremes(apart));
});

test("a silent converter is reported, and taken up again with its settings", () => {
  const box = new Box({ signal: () => [1234, -5] }).open();
  box.run(20);
  box.heard();
  box.converter.silent = true;
  box.run(1000);
  const silent = box.reports();
  complete(silent);
  assert.ok(silent.length >= 990, `${silent.length} reports`);
  assert.ok(silent.slice(4).every((report) => report.silent && report.normal === 0));
  box.converter.silent = false;
  box.run(300);
  const after = box.reports();
  complete(after);
  assert.ok(!after.at(-1).silent);
  assert.ok(after.every((report) => report.silent || report.normal === 1234));
  box.arm();
  assert.equal(box.enabled, true);
});

test("a torn frame and a converter that has lost its gain count for nothing", () => {
  const box = new Box({ signal: () => [1234, -5] }).open();
  box.run(20);
  box.heard();
  box.converter.torn = 1;
  box.run(20);
  let reports = box.reports();
  complete(reports);
  assert.equal(reports.filter((report) => report.silent).length, 1);
  assert.ok(reports.every((report) => report.silent || report.normal === 1234));
  const resets = box.converter.resets;
  box.converter.signal = () => [box.converter.locked ? 1234 : 9, -5];
  box.converter.brownOut();
  box.run(20);
  reports = box.reports();
  assert.ok(reports.every((report) => report.silent || report.normal === 1234));
  assert.ok(reports.some((report) => report.silent));
  assert.ok(!reports.at(-1).silent, "set again");
  assert.equal(box.converter.resets, resets + 2);
});

test("both ends of the converter's range are said", () => {
  let counts = [0x7fffff, 0];
  const box = new Box({ signal: () => counts }).open();
  const ends = (pair) => {
    counts = pair;
    box.run(10);
    const { normal, lateral, normalSaturated, lateralSaturated } = box.reports().at(-1);
    return [normal, lateral, normalSaturated, lateralSaturated];
  };
  assert.deepEqual(ends([0x7fffff, 0]), [8388607, 0, true, false]);
  assert.deepEqual(ends([0, -0x800000]), [0, -8388608, false, true]);
  assert.deepEqual(ends([0x7ffffe, -0x7fffff]), [8388606, -8388607, false, false]);
});

test("bytes that are no message do nothing", () => {
  const box = new Box().open();
  const draw = random(SEED);
  const noise = (length) => Array.from({ length }, () => Math.floor(256 * draw()));
  for (let k = 0; k < 40; k++) {
    box.host.send(noise(500));
    box.run(3);
  }
  const on = word(7, true, false);
  for (let bit = 0; bit < 8 * (on.length - 1); bit++) {
    const turned = [...on];
    turned[bit >> 3] ^= 1 << (bit & 7);
    // Another of these might be an end of a frame, and what follows the rest of one.
    box.host.send([0, ...turned]);
    box.run(0.5);
  }
  assert.deepEqual(box.rises, { enable: 0, heartbeat: 0 });
  box.host.send([0]);
  box.heard();
  box.ask();
  box.run(2);
  assert.ok(box.heard().some((message) => message.kind === "identity"));
  box.arm();
  for (let k = 0; k < 50; k++) {
    box.host.send([...noise(200), 0]);
    box.drive(4);
    assert.equal(box.enabled, true, "words between noise");
  }
});

test("nothing old is said to whoever opens the port", () => {
  const box = new Box().open();
  box.run(50);
  box.host.setOpen(false);
  box.run(1000);
  box.heard();
  const opened = box.chip.now / 1000;
  box.host.setOpen(true);
  box.run(20);
  const [identity, ...reports] = box.heard();
  assert.equal(identity.kind, "identity");
  complete(reports);
  assert.ok(reports[0].us > opened - 2_000);
});

test("a computer that does not read loses reports and nothing else", () => {
  const box = new Box().open();
  box.arm();
  box.host.setReading(false);
  box.drive(500);
  assert.equal(box.enabled, true);
  box.heard();
  box.host.setReading(true);
  box.drive(100);
  const numbers = box.reports().map((report) => report.number);
  const gaps = numbers.filter((number, k) => k > 0 && number !== ((numbers[k - 1] + 1) & 0xffff));
  assert.equal(gaps.length, 1, "one gap");
  assert.equal(box.enabled, true);
});

test("a firmware that hangs is reset while the enable is on", (context) => {
  const box = new Box().open();
  box.arm();
  box.drive(20);
  const hungAt = box.chip.now;
  // The guard's interrupt comes no more.
  box.chip.rp2040.core.enabledInterrupts &= ~(1 << 27);
  box.run(200);
  const ms = (box.chip.resetAt - hungAt) / MS;
  context.diagnostic(`reset after ${ms.toFixed(3)} ms`);
  assert.ok(ms <= 51);
  assert.equal(box.enabled, false, "its pins float");
});

test("the drawing of the wiring shows the pins of the table", () => {
  const drawing = readFileSync(new URL("../../../../../docs/field-box-wiring.svg", import.meta.url), "utf8");
  const drawn = [...drawing.matchAll(/>[^<]*GP(\d+)</g)].map(([, pin]) => Number(pin));
  assert.deepEqual(drawn.sort(), Object.values(new Box().pins).sort());
});
