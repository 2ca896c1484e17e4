//! ADS131M02 of Texas Instruments: two simultaneously sampled channels of 24 bits. Section numbers refer to its data sheet,
//! SBAS853A (April 2021).

use crc::{CRC_16_IBM_3740, Crc};
use embedded_hal::spi::{Operation, SpiDevice};

/// Checksum of the frames: CCITT polynomial, seed 0xFFFF (8.5.1.8).
const CRC: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);
const WORD_BYTES: usize = 3;
/// Response, two channels, CRC.
const FRAME_BYTES: usize = 4 * WORD_BYTES;

// Commands (8.5.1.10).
const NULL: u16 = 0x0000;
const LOCK: u16 = 0x0555;
const READ_REGISTER: u16 = 0xA000;
const WRITE_REGISTER: u16 = 0x6000;

// Registers (8.6), and their values.
const MODE: u16 = 0x02;
/// Words of 24 bits, SPI time-out on; clears the reset flag.
const MODE_VALUE: u16 = 0x0110;
const CLOCK: u16 = 0x03;
/// Both channels on, OSR 2048, high resolution.
const CLOCK_VALUE: u16 = 0x0312;
const GAIN: u16 = 0x04;

/// Oversampling ratio: periods of the modulator clock, which is half the converter's clock, per conversion.
pub const OSR: u32 = 2048;

/// Bits of the status that are checked: all but F_RESYNC and the reserved ones (8.6.2).
const STATUS_MASK: u16 = 0xBF03;
/// Registers locked, words of 24 bits, no reset, no error.
const STATUS_CONFIGURED: u16 = 0x8100;
/// Both channels have a new conversion.
const STATUS_FRESH: u16 = 0x0003;

/// Gain of the amplifiers before both channels; the range is ±1.2 V divided by the gain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChannelGain {
    /// ±1.2 V.
    X1 = 0,
    /// ±600 mV.
    X2 = 1,
    /// ±300 mV.
    X4 = 2,
    /// ±150 mV.
    X8 = 3,
    /// ±75 mV.
    X16 = 4,
    /// ±37.5 mV.
    X32 = 5,
    /// ±18.75 mV.
    X64 = 6,
    /// ±9.375 mV, for a strain gauge bridge of 2 mV/V.
    X128 = 7,
}

/// Reason for a missing reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ConverterFault {
    /// The SPI failed.
    Spi,
    /// The checksum of the frame is wrong: no answer, another device, or a disturbance.
    Torn,
    /// No new conversion since the last frame.
    Stale,
    /// The converter has lost its settings: its supply or a disturbance has reset it.
    Reset,
    /// A register reads back a value other than the one written.
    Refused,
}

/// The converter on its SPI: mode 1, at most 25 MHz.
#[derive(Debug)]
pub struct Ads131m02<SPI> {
    spi: SPI,
    gain: ChannelGain,
}

struct Frame {
    response: u16,
    counts: [i32; 2],
}

impl<SPI: SpiDevice> Ads131m02<SPI> {
    /// Takes the converter on `spi`, without communicating yet.
    pub fn new(spi: SPI, gain: ChannelGain) -> Self {
        Self { spi, gain }
    }

    /// Configures the converter after a reset by its pin, reads the settings back, and locks them.
    ///
    /// # Errors
    /// If the converter does not answer, or a value read back differs.
    pub fn configure(&mut self) -> Result<(), ConverterFault> {
        let gain = self.gain as u16;
        let registers = [
            (MODE, MODE_VALUE),
            (CLOCK, CLOCK_VALUE),
            (GAIN, gain << 4 | gain),
        ];
        for (register, value) in registers {
            self.exchange(WRITE_REGISTER | register << 7, value)?;
        }
        for (register, value) in registers {
            // The response to a command comes in the next frame.
            self.exchange(READ_REGISTER | register << 7, 0)?;
            if self.exchange(NULL, 0)?.response != value {
                return Err(ConverterFault::Refused);
            }
        }
        self.exchange(LOCK, 0)?;
        // Unread conversions wait in a buffer of two (8.5.1.9.1).
        self.exchange(NULL, 0)?;
        self.exchange(NULL, 0)?;
        Ok(())
    }

    /// Reads the conversion that is ready: both channels, counts of 24 bits.
    ///
    /// # Errors
    /// If there is no valid new conversion.
    pub fn read(&mut self) -> Result<[i32; 2], ConverterFault> {
        let Frame { response, counts } = self.exchange(NULL, 0)?;
        let status = response & STATUS_MASK;
        if status & !STATUS_FRESH != STATUS_CONFIGURED {
            return Err(ConverterFault::Reset);
        }
        if status & STATUS_FRESH != STATUS_FRESH {
            return Err(ConverterFault::Stale);
        }
        Ok(counts)
    }

    fn exchange(&mut self, command: u16, value: u16) -> Result<Frame, ConverterFault> {
        let mut frame = [0; FRAME_BYTES];
        frame[..2].copy_from_slice(&command.to_be_bytes());
        frame[WORD_BYTES..WORD_BYTES + 2].copy_from_slice(&value.to_be_bytes());
        let mut operations = [Operation::TransferInPlace(&mut frame)];
        let transferred = self.spi.transaction(&mut operations);
        transferred.map_err(|_| ConverterFault::Spi)?;
        let [r0, r1, _, n0, n1, n2, l0, l1, l2, c0, c1, _] = frame;
        if CRC.checksum(&frame[..3 * WORD_BYTES]) != u16::from_be_bytes([c0, c1]) {
            return Err(ConverterFault::Torn);
        }
        // The upper byte carries the sign.
        let signed = |high, middle, low| i32::from_be_bytes([high, middle, low, 0]) >> 8;
        Ok(Frame {
            response: u16::from_be_bytes([r0, r1]),
            counts: [signed(n0, n1, n2), signed(l0, l1, l2)],
        })
    }
}
