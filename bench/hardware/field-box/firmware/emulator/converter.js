// An ADS131M02 by its data sheet (SBAS853A), on SPI0.
const NS_PER_BYTE = 1000;
const CLOCK_HZ = 8e6;
const WORD_BYTES = 3;
const FRAME_BYTES = 4 * WORD_BYTES;
const RESET_NS = 2048e9 / CLOCK_HZ;
const [STATUS, MODE, CLOCK] = [1, 2, 3];

/** CRC-16 of the CCITT, bit by bit. */
export function crc16(bytes) {
  let crc = 0xffff;
  for (const byte of bytes) {
    crc ^= byte << 8;
    for (let bit = 0; bit < 8; bit++) crc = ((crc << 1) ^ (crc & 0x8000 ? 0x1021 : 0)) & 0xffff;
  }
  return crc;
}

export class Converter {
  /** @param signal counts of both channels at a time in ns */
  constructor(chip, pins, signal) {
    Object.assign(this, { chip, pins, signal });
    this.silent = false;
    this.torn = 0;
    this.resets = 0;
    this.conversions = 0;
    this.#reset();
    const spi = chip.rp2040.spi[0];
    spi.onTransmit = (byte) => {
      const answer = this.selected && !this.silent ? this.#exchange(byte) : 0;
      chip.after(NS_PER_BYTE, () => spi.completeTransmit(answer));
    };
    chip.onLevel(pins.cs, (high) => (high ? this.#end() : this.#begin()));
    chip.onLevel(pins.reset, (high) => {
      if (!high) this.resetAt = chip.now;
      else if (chip.now - this.resetAt >= RESET_NS) this.#reset();
    });
    chip.setInput(pins.drdy, true);
    this.#later();
  }

  /** Loses its settings, as by a fault of its supply. */
  brownOut() {
    this.#reset();
  }

  get locked() {
    return this.lockedBy === 0x0555;
  }

  /** Nanoseconds from one conversion to the next. */
  get period() {
    const osr = 128 << ((this.registers[CLOCK] >> 2) & 7);
    return (2e9 * osr) / CLOCK_HZ;
  }

  #reset() {
    this.resets++;
    this.registers = new Uint16Array(64);
    this.registers.set([0x2282, 0x0500, 0x0510, 0x030e]);
    this.lockedBy = 0;
    this.answer = null;
    this.fresh = false;
    this.counts = [0, 0];
  }

  #later() {
    this.chip.after(this.period, () => {
      if (!this.silent) {
        this.conversions++;
        // The filter of third order is symmetric about this time.
        this.counts = this.signal(this.chip.now - 1.5 * this.period);
        this.fresh = true;
        this.chip.setInput(this.pins.drdy, true);
        this.chip.setInput(this.pins.drdy, false);
      }
      this.#later();
    });
  }

  get #status() {
    const reset = this.registers[MODE] & 0x0400;
    return (this.locked ? 0x8000 : 0) | reset | 0x0100 | (this.fresh ? 3 : 0);
  }

  #begin() {
    this.selected = true;
    this.heard = [];
    const frame = [];
    const word = (value) => frame.push((value >> 16) & 255, (value >> 8) & 255, value & 255);
    word((this.answer ?? this.#status) << 8);
    for (const count of this.counts) word(count);
    word(crc16(frame) << 8);
    if (this.torn > 0) {
      this.torn--;
      frame[4] ^= 0x10;
    }
    this.frame = frame;
  }

  #exchange(byte) {
    this.heard.push(byte);
    return this.frame[this.heard.length - 1] ?? 0;
  }

  #end() {
    this.selected = false;
    if (this.silent || !this.heard || this.heard.length < FRAME_BYTES) return;
    this.fresh = false;
    this.chip.setInput(this.pins.drdy, true);
    const command = (this.heard[0] << 8) | this.heard[1];
    const register = (command >> 7) & 63;
    this.answer = null;
    if (command >> 13 === 5) this.answer = register === STATUS ? this.#status : this.registers[register];
    else if (this.locked) {
      if (command === 0x0655) this.lockedBy = 0;
    } else if (command >> 13 === 3) {
      this.registers[register] = (this.heard[3] << 8) | this.heard[4];
      this.answer = 0x4000 | (command & 0x1fff);
    } else if (command === 0x0555) {
      this.lockedBy = command;
      this.answer = command;
    }
  }
}
