// What bench and box say, by docs/field-box-protocol.md, and by none of the firmware's code.
import { crc16 } from "./converter.js";

const VERSION = 0xb1;
const [IDENTITY, REPORT, ASK, WORD] = [0x01, 0x02, 0x10, 0x11];
export const STOPS = ["none", "silence", "estop", "not released"];

function frame(kind, fields) {
  const raw = [VERSION, kind, ...fields];
  const crc = crc16(raw);
  raw.push(crc & 255, crc >> 8);
  const out = [];
  let run = [];
  for (const byte of [...raw, 0]) {
    if (byte !== 0) run.push(byte);
    else {
      out.push(run.length + 1, ...run);
      run = [];
    }
  }
  return [...out, 0];
}

export const ask = () => frame(ASK, []);
export const word = (number, enable, heartbeat) =>
  frame(WORD, [number & 255, (number >> 8) & 255, (enable ? 1 : 0) | (heartbeat ? 2 : 0)]);

/** Hears messages among bytes. */
export class Listener {
  constructor() {
    this.bytes = [];
    this.torn = 0;
  }

  hear(bytes) {
    const heard = [];
    for (const byte of bytes) {
      if (byte !== 0) {
        this.bytes.push(byte);
        continue;
      }
      const message = decode(this.bytes);
      if (message) heard.push(message);
      else this.torn++;
      this.bytes = [];
    }
    return heard;
  }
}

function decode(stuffed) {
  const raw = [];
  for (let at = 0; at < stuffed.length; at += stuffed[at]) {
    if (at > 0) raw.push(0);
    raw.push(...stuffed.slice(at + 1, at + stuffed[at]));
  }
  const body = raw.slice(0, -2);
  if (raw.length < 4 || crc16(body) !== raw.at(-2) + 256 * raw.at(-1) || body[0] !== VERSION) return null;
  const at = new DataView(Uint8Array.from(body.slice(2)).buffer);
  if (body[1] === IDENTITY && at.byteLength === 14) {
    return {
      kind: "identity",
      firmware: body.slice(2, 5).join("."),
      serial: Buffer.from(body.slice(5, 13)).toString("hex").toUpperCase(),
      reportHz: at.getUint16(11, true),
      bits: at.getUint8(13),
    };
  }
  if (body[1] !== REPORT || at.byteLength !== 22) return null;
  const levels = at.getUint8(18);
  const level = (place) => ((levels >> place) & 1) === 1;
  return {
    kind: "report",
    number: at.getUint16(0, true),
    us: at.getUint32(2, true),
    normal: at.getInt32(6, true),
    lateral: at.getInt32(10, true),
    position: at.getInt32(14, true),
    estopClosed: level(0),
    button: level(1),
    deadMan: level(2),
    enable: level(3),
    heartbeat: level(4),
    normalSaturated: level(5),
    lateralSaturated: level(6),
    silent: level(7),
    stop: STOPS[at.getUint8(19)],
    heard: at.getUint16(20, true),
  };
}
