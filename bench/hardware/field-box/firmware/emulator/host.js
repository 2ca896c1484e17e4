// The computer at the other end of the USB cable: enumerates the box, and opens its port.
const BUFFERS = 0x80;
const [AVAILABLE, FULL, LENGTH] = [1 << 10, 1 << 15, 0x3ff];
/** Time from a packet's being ready to its being on the way, ns; a computer asks many times a millisecond. */
const TRANSACTION_NS = 50_000;
const [CONFIGURATION, STRING] = [2, 3];
const [SET_ADDRESS, GET_DESCRIPTOR, SET_CONFIGURATION, SET_LINE_STATE] = [5, 6, 9, 0x22];

export class Host {
  constructor(chip, onBytes) {
    Object.assign(this, { chip, onBytes });
    const { usbCtrl } = chip.rp2040;
    this.usb = usbCtrl;
    this.view = chip.rp2040.usbDPRAMView;
    this.reading = true;
    this.outbox = [];
    this.packets = 0;
    // The emulator takes every packet at once, and gives one that is not there: it has no NAK. This has.
    usbCtrl.DPRAMUpdated = (offset, value) => this.#armed(offset, value);
    usbCtrl.onUSBEnabled = () => usbCtrl.resetDevice();
    usbCtrl.onResetReceived = () => this.#enumerate();
  }

  /** Opens or closes the port. */
  setOpen(open) {
    this.#control([0x21, SET_LINE_STATE, open ? 1 : 0, 0, 0, 0, 0, 0]);
  }

  /** Reads no more, or again. */
  setReading(reading) {
    this.reading = reading;
    if (reading && this.heldBack !== undefined) {
      const endpoint = this.heldBack;
      this.heldBack = undefined;
      this.#take(endpoint);
    }
  }

  send(bytes) {
    for (let at = 0; at < bytes.length; at += 64) this.outbox.push(Uint8Array.from(bytes.slice(at, at + 64)));
    this.#give();
  }

  #enumerate() {
    this.address = undefined;
    this.waiting = undefined;
    this.#control([0, SET_ADDRESS, 1, 0, 0, 0, 0, 0], () => {
      this.#control([0x80, GET_DESCRIPTOR, 3, STRING, 9, 4, 64, 0], (digits) => {
        this.serial = Buffer.from(digits.slice(2)).toString("utf16le");
        this.#control([0x80, GET_DESCRIPTOR, 0, CONFIGURATION, 0, 0, 255, 0], (descriptors) => {
          this.#findEndpoints(descriptors);
          this.#control([0, SET_CONFIGURATION, 1, 0, 0, 0, 0, 0], () => {
            this.ready = true;
          });
        });
      });
    });
  }

  #findEndpoints(descriptors) {
    let data = false;
    for (let at = 0; at < descriptors.length; at += descriptors[at]) {
      const [, type, address] = descriptors.slice(at);
      if (type === 4) data = descriptors[at + 5] === 10;
      if (type === 5 && data) this[address & 0x80 ? "in" : "out"] = address & 15;
    }
  }

  #control(setup, then) {
    this.transfer = { then, data: [], length: setup[6], isIn: (setup[0] & 0x80) !== 0 };
    this.usb.sendSetupPacket(Uint8Array.from(setup));
  }

  #armed(offset, value) {
    if (offset < BUFFERS || offset >= BUFFERS + 0x80 || !(value & AVAILABLE)) return;
    const endpoint = (offset - BUFFERS) >> 3;
    if (offset & 4) {
      if (endpoint === this.out) {
        this.waiting = true;
        this.#give();
      } else if (endpoint === 0) {
        // The status of a control transfer that was read.
        this.chip.after(TRANSACTION_NS, () => this.#finish(endpoint, new Uint8Array()));
      }
    } else this.chip.after(TRANSACTION_NS, () => this.#take(endpoint));
  }

  /** Takes a packet from the box. */
  #take(endpoint) {
    if (endpoint === this.in && !this.reading) {
      this.heldBack = endpoint;
      return;
    }
    const at = BUFFERS + 8 * endpoint;
    const value = this.view.getUint32(at, true);
    if (!(value & AVAILABLE)) return;
    const place = this.usb.getEndpointBufferOffset(endpoint, false);
    const bytes = this.chip.rp2040.usbDPRAM.slice(place, place + (value & LENGTH));
    this.view.setUint32(at, value & ~(AVAILABLE | FULL), true);
    this.usb.indicateBufferReady(endpoint, false);
    if (endpoint === this.in) {
      this.packets++;
      this.onBytes(bytes);
    }
    if (endpoint === 0) this.#controlled(bytes);
  }

  #controlled(bytes) {
    const { transfer } = this;
    if (!transfer) return;
    transfer.data.push(...bytes);
    if (transfer.isIn && bytes.length === 64 && transfer.data.length < transfer.length) return;
    this.transfer = undefined;
    // After the status.
    this.chip.after(4 * TRANSACTION_NS, () => transfer.then?.(transfer.data));
  }

  /** Gives the box a packet, if both are there. */
  #give() {
    if (!this.waiting || this.outbox.length === 0) return;
    this.waiting = false;
    const packet = this.outbox.shift();
    this.chip.after(TRANSACTION_NS, () => this.#finish(this.out, packet));
  }

  #finish(endpoint, bytes) {
    const at = BUFFERS + 8 * endpoint + 4;
    const value = this.view.getUint32(at, true);
    if (!(value & AVAILABLE)) return;
    const place = this.usb.getEndpointBufferOffset(endpoint, true);
    this.chip.rp2040.usbDPRAM.set(bytes, place);
    this.view.setUint32(at, (value & ~(AVAILABLE | LENGTH)) | FULL | bytes.length, true);
    this.usb.indicateBufferReady(endpoint, true);
  }
}
