// A field box on the bench: chip, converter, encoder, contacts, computer.
import { readFileSync } from "node:fs";
import { Chip } from "./chip.js";
import { ask, Listener, word } from "./codec.js";
import { Converter } from "./converter.js";
import { Host } from "./host.js";

export const MS = 1e6;
export const UNIQUE_ID = [0xe6, 0x61, 0x41, 0x04, 0x03, 0x00, 0x2a, 0x21];
/** Time between two words of a bench, ns. */
export const WORD_NS = 2 * MS;

/** The table of docs/field-box.md, which whoever wires a box goes by: number of the GPIO by the line's name. */
function wiring() {
  const page = readFileSync(new URL("../../../../../docs/field-box.md", import.meta.url), "utf8");
  const rows = page.matchAll(/^\| GP(\d+) \| ([\w -]+) \|/gm);
  return Object.fromEntries([...rows].map(([, number, line]) => [line, Number(number)]));
}

export class Box {
  /** Powers a box that holds the image which `FIELD_BOX_IMAGE` names, and waits until its port is open. */
  constructor({ signal = () => [0, 0] } = {}) {
    const image = process.env.FIELD_BOX_IMAGE;
    if (!image) throw new Error("FIELD_BOX_IMAGE names no image: run ./dev firmware");
    this.pins = wiring();
    this.chip = new Chip(image, UNIQUE_ID);
    this.rises = { enable: 0, heartbeat: 0 };
    this.fellAt = undefined;
    this.watch("enable");
    this.watch("heartbeat");
    this.converter = new Converter(
      this.chip,
      { cs: this.pins["converter CS"], drdy: this.pins["converter DRDY"], reset: this.pins["converter RESET"] },
      signal,
    );
    this.listener = new Listener();
    this.messages = [];
    this.host = new Host(this.chip, (bytes) => this.messages.push(...this.listener.hear(bytes)));
    this.number = 0;
    this.beat = false;
    this.count = 0;
    this.input("e-stop", true);
  }

  /** Opens the port of a box that was powered. */
  open() {
    this.chip.run(this.chip.now + 500 * MS, () => this.host.ready);
    if (!this.host.ready) throw new Error("the box does not enumerate");
    this.host.setOpen(true);
    this.run(5);
    return this;
  }

  watch(line) {
    this.chip.onLevel(this.pins[line], (high) => {
      if (high) this.rises[line]++;
      else if (line === "enable") this.fellAt = this.chip.now;
    });
  }

  input(line, closed) {
    this.chip.setInput(this.pins[line], closed);
  }

  get enabled() {
    return this.chip.isHigh(this.pins.enable);
  }

  /** Runs for a time, ms. */
  run(ms, done) {
    return this.chip.run(this.chip.now + ms * MS, done);
  }

  ask() {
    this.host.send(ask());
  }

  say(enable, heartbeat = false) {
    this.number = (this.number + 1) & 0xffff;
    this.host.send(word(this.number, enable, heartbeat));
  }

  /** Says words as a bench that drives, for a time, ms. */
  drive(ms) {
    const end = this.chip.now + ms * MS;
    while (this.chip.now < end) {
      this.beat = !this.beat;
      this.say(true, this.beat);
      this.chip.run(Math.min(end, this.chip.now + WORD_NS));
    }
  }

  /** Lets go of the enable and turns it on. */
  arm() {
    this.say(false);
    this.drive(4);
  }

  /** Takes what the box has said since the last time. */
  heard() {
    return this.messages.splice(0);
  }

  reports() {
    return this.heard().filter((message) => message.kind === "report");
  }

  /** Moves the encoder by one count, up where channel B leads. */
  step(up) {
    this.count += up ? 1 : -1;
    const phase = ((this.count % 4) + 4) % 4;
    this.input("encoder A", phase >= 2);
    this.input("encoder B", phase === 1 || phase === 2);
  }
}

/** Numbers that look random, the same for the same seed (Marsaglia's xorshift32). */
export function random(seed) {
  let state = seed | 0 || 1;
  return () => {
    state ^= state << 13;
    state ^= state >>> 17;
    state ^= state << 5;
    return (state >>> 0) / 2 ** 32;
  };
}
