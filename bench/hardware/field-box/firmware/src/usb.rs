//! Serial port of the box.

use embassy_executor::Spawner;
use embassy_futures::join::join3;
use embassy_rp::peripherals::USB;
use embassy_rp::usb::{Driver, InterruptHandler};
use embassy_rp::{Peri, bind_interrupts};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_usb::class::cdc_acm::{CdcAcmClass, Receiver, Sender, State};
use embassy_usb::{Builder, Config};
use field_box_wire::{BoxIdentity, Encoded, FromBox, LONGEST_BYTES, Listener, ToBox};
use static_cell::StaticCell;

use crate::guard::WORDS;

bind_interrupts!(struct Irqs {
    USBCTRL_IRQ => InterruptHandler<USB>;
});

type Bus = Driver<'static, USB>;

/// Vendor and product for testing, of <https://pid.codes/1209/0001/>: boxes for sale need their own product number.
const VENDOR: u16 = 0x1209;
const PRODUCT: u16 = 0x0001;
/// Bytes of a packet at full speed.
const PACKET_BYTES: usize = 64;
const CONVERTER_BITS: u8 = 24;

/// Queue of messages to the bench: about 1/30 s of reports.
static OUTBOX: Channel<CriticalSectionRawMutex, Encoded, 64> = Channel::new();

/// Queues a message, or drops it if 64 are waiting: the sequence numbers then show the bench the number lost.
pub fn say(message: FromBox) {
    let _ = OUTBOX.try_send(message.encode());
}

/// Starts the port of the box with this serial number, which sends `report_hz` readings a second.
pub fn start(spawner: Spawner, usb: Peri<'static, USB>, serial: [u8; 8], report_hz: u16) {
    spawner.spawn(run(usb, serial, report_hz).unwrap());
}

#[embassy_executor::task]
async fn run(usb: Peri<'static, USB>, serial: [u8; 8], report_hz: u16) {
    static DIGITS: StaticCell<[u8; 16]> = StaticCell::new();
    static CONFIGURATION: StaticCell<[u8; 256]> = StaticCell::new();
    static BOS: StaticCell<[u8; 256]> = StaticCell::new();
    static CONTROL: StaticCell<[u8; 64]> = StaticCell::new();
    static STATE: StaticCell<State> = StaticCell::new();

    let mut config = Config::new(VENDOR, PRODUCT);
    config.manufacturer = Some("friction-bench");
    config.product = Some("Field box");
    config.serial_number = core::str::from_utf8(DIGITS.init(digits(serial))).ok();
    config.max_power = 250;
    let mut builder = Builder::new(
        Driver::new(usb, Irqs),
        config,
        CONFIGURATION.init([0; 256]),
        BOS.init([0; 256]),
        &mut [],
        CONTROL.init([0; 64]),
    );
    let port = CdcAcmClass::new(&mut builder, STATE.init(State::new()), PACKET_BYTES as u16);
    let (sender, receiver) = port.split();
    let identity = FromBox::Identity(BoxIdentity {
        firmware: version(),
        serial,
        report_hz,
        converter_bits: CONVERTER_BITS,
    });
    let mut device = builder.build();
    join3(
        device.run(),
        speak(sender, identity),
        listen(receiver, identity),
    )
    .await;
}

/// Sends queued messages while a program has the port open.
async fn speak(mut port: Sender<'static, Bus>, identity: FromBox) {
    let mut is_open = false;
    loop {
        port.wait_connection().await;
        loop {
            let mut encoded = OUTBOX.receive().await;
            if !port.dtr() {
                // Messages are dropped while the port is closed; the next reader would take them for new.
                is_open = false;
                continue;
            }
            let mut packet = [0; 2 * LONGEST_BYTES];
            let mut length = 0;
            if !is_open {
                is_open = true;
                OUTBOX.clear();
                encoded = identity.encode();
            }
            // Two messages are shorter than a packet, which therefore ends a transfer.
            loop {
                packet[length..length + encoded.len()].copy_from_slice(&encoded);
                length += encoded.len();
                if length > LONGEST_BYTES {
                    break;
                }
                match OUTBOX.try_receive() {
                    Ok(message) if length + message.len() < PACKET_BYTES => encoded = message,
                    _ => break,
                }
            }
            if port.write_packet(&packet[..length]).await.is_err() {
                is_open = false;
                break;
            }
        }
    }
}

/// Receives messages of the bench; invalid bytes are ignored.
async fn listen(mut port: Receiver<'static, Bus>, identity: FromBox) {
    let mut packet = [0; PACKET_BYTES];
    loop {
        port.wait_connection().await;
        let mut listener = Listener::<ToBox>::default();
        while let Ok(length) = port.read_packet(&mut packet).await {
            for &byte in &packet[..length] {
                match listener.hear(byte) {
                    Some(Ok(ToBox::Ask)) => say(identity),
                    Some(Ok(ToBox::Word(word))) => {
                        let _ = WORDS.try_send(word);
                    }
                    Some(Err(_)) | None => {}
                }
            }
        }
    }
}

fn digits(serial: [u8; 8]) -> [u8; 16] {
    let digit = |nibble: u8| b"0123456789ABCDEF"[usize::from(nibble & 0xF)];
    core::array::from_fn(|index| {
        let byte = serial[index / 2];
        digit(if index % 2 == 0 { byte >> 4 } else { byte })
    })
}

/// Returns the version of this firmware: major, minor, patch.
fn version() -> [u8; 3] {
    [
        env!("CARGO_PKG_VERSION_MAJOR"),
        env!("CARGO_PKG_VERSION_MINOR"),
        env!("CARGO_PKG_VERSION_PATCH"),
    ]
    .map(|part| part.parse().unwrap_or(u8::MAX))
}
