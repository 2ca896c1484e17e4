// An RP2040 with the firmware's image in its flash.
import { readFileSync } from "node:fs";
import { GPIOPinState, LogLevel, ConsoleLogger, RP2040 } from "rp2040js";

const NS_PER_CYCLE = 8;
const FLASH = 0x10000000;
const RAM = 0x20000000;
/** Commands and registers of the flash interface. */
const READ_UNIQUE_ID = 0x4b;
const SSI_DATA = 0x60;
const SSI_ENABLE = 0x08;
/** Most instructions of the counter after which a change of its pins, or of its queue, has had all its effect. */
const COUNTER_SETTLES = 128;

/**
 * What the firmware calls of the boot ROM, in the place of Raspberry Pi's: the functions around a command to the flash do
 * nothing here, and memcpy44 copies.
 */
function bootrom() {
  const rom = new Uint16Array(0x2000);
  const [nothing, copy, lookup] = [0x100, 0x120, 0x140];
  rom[0x18 / 2] = lookup | 1;
  rom.set([0x4770], nothing / 2); // bx lr
  rom.set(
    [
      0x3a04, // subs r2, #4
      0xd402, // bmi done
      0x588b, // ldr r3, [r1, r2]
      0x5083, // str r3, [r0, r2]
      0xe7fa, // b to the first
      0x4770, // done: bx lr
    ],
    copy / 2,
  );
  rom.set(
    [
      0x4a03, // ldr r2, ='C4'
      0x4291, // cmp r1, r2
      0xd001, // beq copy
      0x4803, // ldr r0, =nothing
      0x4770, // bx lr
      0x4803, // copy: ldr r0, =copy
      0x4770, // bx lr
      0x0000,
      0x3443,
      0x0000,
      nothing | 1,
      0x0000,
      copy | 1,
      0x0000,
    ],
    lookup / 2,
  );
  return new Uint32Array(rom.buffer);
}

/** Puts what an ELF file says into flash. */
function load(elf, flash) {
  const at = new DataView(elf.buffer, elf.byteOffset, elf.byteLength);
  if (at.getUint32(0) !== 0x7f454c46) throw new Error("the image is no ELF file");
  const [table, size, count] = [at.getUint32(28, true), at.getUint16(42, true), at.getUint16(44, true)];
  for (let k = 0; k < count; k++) {
    const header = table + k * size;
    const [type, offset, , place, length] = [0, 4, 8, 12, 16].map((field) => at.getUint32(header + field, true));
    if (type !== 1 || length === 0) continue;
    if (place < FLASH || place >= RAM) throw new Error(`the image has a part at ${place.toString(16)}`);
    flash.set(elf.subarray(offset, offset + length), place - FLASH);
  }
}

/** The chip. Time is in ns of its own clock, which begins when it is powered. */
export class Chip {
  constructor(image, uniqueId) {
    this.rp2040 = new RP2040();
    this.clock = this.rp2040.clock;
    this.rp2040.logger = new ConsoleLogger(LogLevel.Error, true);
    this.rp2040.loadBootrom(bootrom());
    // The flash's cache, which the emulator has not: nothing streams.
    this.rp2040.peripherals[0x14000] = { readUint32: () => 0, writeUint32Atomic: () => {} };
    load(readFileSync(image), this.rp2040.flash);
    this.#giveId(uniqueId);
    this.#slowCounter();
    this.rp2040.peripherals[0x40058].onWatchdogTrigger = () => this.#reset();
    // The ROM has checked the second stage in flash, and runs it.
    this.rp2040.core.SP = RAM + 0x42000;
    this.rp2040.core.LR = 0;
    this.rp2040.core.PC = FLASH;
  }

  get now() {
    return this.clock.nanos;
  }

  /** Runs until `until`, or until `done` holds. */
  run(until, done = () => false) {
    const { core } = this.rp2040;
    const { clock } = this;
    while (clock.nanos < until && this.resetAt === undefined) {
      if (core.waiting) {
        const next = clock.nextAlarm ? clock.nanosToNextAlarm : Infinity;
        clock.tick(Math.max(0, Math.min(next, until - clock.nanos)));
      } else {
        clock.tick(core.executeInstruction() * NS_PER_CYCLE);
      }
      if (done()) return true;
    }
    return false;
  }

  /** Calls back after `ns`. */
  after(ns, callback) {
    this.clock.createAlarm(callback).schedule(ns);
  }

  /** Whether an output is high; it is low while it floats, as a resistor pulls it down. */
  isHigh(pin) {
    return this.rp2040.gpio[pin].value === GPIOPinState.High;
  }

  onLevel(pin, callback) {
    this.rp2040.gpio[pin].addListener((value) => callback(value === GPIOPinState.High));
  }

  setInput(pin, high) {
    this.counterToNow();
    this.rp2040.gpio[pin].setInputValue(high);
    this.counterLeft = COUNTER_SETTLES;
  }

  /** A reset by the watchdog ends the run: the pins float. */
  #reset() {
    this.resetAt = this.now;
    this.rp2040.peripherals[0x40058].alarm.enable = false;
    for (const pin of this.rp2040.gpio) {
      pin.ctrl = 0x1f;
      pin.checkForUpdates();
    }
  }

  /** The emulator's flash has no number. */
  #giveId(uniqueId) {
    const ssi = this.rp2040.peripherals[0x18000];
    const [read, write] = [ssi.readUint32.bind(ssi), ssi.writeUint32.bind(ssi)];
    let answers = null;
    ssi.writeUint32 = (offset, value) => {
      if (offset === SSI_ENABLE) answers = null;
      if (offset === SSI_DATA && answers === null && (value & 0xff) === READ_UNIQUE_ID) answers = [0, 0, 0, 0, ...uniqueId];
      write(offset, value);
    };
    ssi.readUint32 = (offset) => (offset === SSI_DATA && answers?.length ? answers.shift() : read(offset));
  }

  /**
   * The emulator runs state machines beside its clock. Here the counter's runs on it: whenever it is looked at or its pins
   * change, it does what it has done since, as far as that has an effect: with the same pins and a full queue it goes in a
   * circle.
   */
  #slowCounter() {
    const pio = this.rp2040.pio[0];
    pio.run = () => {};
    this.counterAt = 0;
    this.counterLeft = COUNTER_SETTLES;
    for (const access of ["readUint32", "writeUint32"]) {
      const original = pio[access].bind(pio);
      pio[access] = (...values) => {
        this.counterToNow();
        this.counterLeft = COUNTER_SETTLES;
        return original(...values);
      };
    }
  }

  counterToNow() {
    const machine = this.rp2040.pio[0].machines[0];
    const cycles = Math.floor((this.clock.nanos - this.counterAt) / NS_PER_CYCLE);
    this.counterAt += cycles * NS_PER_CYCLE;
    if (!machine.enabled) return;
    const steps = Math.min(cycles, this.counterLeft);
    for (let k = 0; k < steps; k++) machine.step();
    this.counterLeft -= steps;
  }
}
