//! Listing, selection and refusal of devices.

use std::process;

use cpal::traits::DeviceTrait;
use signalgen::{
    Generator, LayoutError, StreamDirection, StreamFormat,
    audio::{
        AudioError, ChoiceError, DuplexConfig, HostChoice, Offer, list_devices, open_duplex,
        open_host, output_device,
    },
};

use super::stepped_card::*;

fn open_error(bench: &Bench, config: &DuplexConfig) -> AudioError {
    open_duplex(&bench.host(), config, Generator::new(settings()), None).unwrap_err()
}

/// Fault 2.
#[test]
fn a_stream_that_the_device_lacks_is_refused_with_its_capabilities() {
    let bench = Bench::default();
    let devices = list_devices(&bench.host()).unwrap();
    let offer = devices[0].input.clone().unwrap();
    let mut four = config(StreamFormat::I32);
    four.input.channels = 4;
    let error = open_error(&bench, &four);
    assert_eq!(
        error,
        AudioError::Unsupported {
            direction: StreamDirection::Input,
            device: "custom:stepped (stepped card)".to_owned(),
            request: "4 channels of i32 at 192000 Hz".to_owned(),
            offered: offer,
        }
    );
    let offer = "2 ch f32 192000 Hz; 2 ch i16 192000 Hz; 2 ch i24 192000 Hz; 2 ch i32 192000 Hz";
    assert!(error.to_string().ends_with(offer), "{error}");

    let mut buffered_config = config(StreamFormat::I32);
    buffered_config.buffer_frames = Some(100);
    match open_error(&bench, &buffered_config) {
        AudioError::Unsupported { request, .. } => {
            assert!(request.ends_with("100 frames per buffer"), "{request}");
        }
        error => panic!("{error}"),
    }
}

/// Cards with packed 24-bit samples alone appear through cpal like this.
/// Fault 2.
#[test]
fn a_card_without_a_format_that_cpal_knows_is_refused_with_the_way_round() {
    let bench = Bench::with_formats(&[]);
    for format in StreamFormat::ALL {
        let error = open_error(&bench, &config(format));
        assert_eq!(
            error,
            AudioError::NoUsableFormat {
                direction: StreamDirection::Output,
                device: "custom:stepped (stepped card)".to_owned(),
                request: format!("3 channels of {format} at 192000 Hz"),
            }
        );
        let message = error.to_string();
        for word in ["S24_3LE", "JACK", "jackd"] {
            assert!(message.contains(word), "{message}");
        }
    }
    let devices = list_devices(&bench.host()).unwrap();
    assert_eq!(devices[0].output, Some(Offer::Listed(Vec::new())));
}

#[test]
fn contradictions_are_refused_by_name() {
    let bench = Bench::default();
    let good = config(StreamFormat::F32);
    let error_after = |change: fn(&mut DuplexConfig)| {
        let mut bad = good.clone();
        change(&mut bad);
        open_error(&bench, &bad)
    };
    for (name, error) in [
        ("sample_rate_hz", error_after(|c| c.sample_rate_hz = 48_000)),
        ("ring_s", error_after(|c| c.ring_s = 0.0)),
        ("ring_s", error_after(|c| c.ring_s = 121.0)),
        ("ring_s", error_after(|c| c.ring_s = f64::NAN)),
    ] {
        match error {
            AudioError::Config { parameter, .. } => assert_eq!(parameter, name),
            error => panic!("{name}: {error}"),
        }
    }
    for (name, error) in [
        ("output.channels", error_after(|c| c.output.channels = 0)),
        ("input.channels", error_after(|c| c.input.channels = 0)),
    ] {
        let zero = LayoutError::Zero { parameter: name };
        assert_eq!(error, AudioError::Layout(zero));
    }
    let no_channel = LayoutError::DriveChannel {
        drive_channel: 3,
        channels: 3,
    };
    assert_eq!(
        error_after(|c| c.drive_channel = 3),
        AudioError::Layout(no_channel)
    );
    let error = error_after(|c| c.input.device = "Babyface".to_owned());
    let no_match = matches!(
        &error,
        AudioError::Device(ChoiceError::NoMatch { request, direction: StreamDirection::Input, .. })
            if request == "Babyface"
    );
    assert!(no_match, "{error}");
}

/// Fault 5.
#[test]
fn a_device_in_use_is_busy() {
    let bench = Bench::default();
    let _held = bench.open(&config(StreamFormat::F32));
    let error = open_error(&bench, &config(StreamFormat::F32));
    let AudioError::Busy { device, holder, .. } = &error else {
        panic!("{error}");
    };
    assert_eq!(device, "custom:stepped (stepped card)");
    // Not a card of this computer.
    assert!(
        holder.contains("sound server") && holder.contains("fuser"),
        "{holder}"
    );
    assert!(error.to_string().contains(&**holder), "{error}");
}

#[test]
fn an_output_for_other_sound_is_chosen_as_the_drives_is() {
    let host = Bench::default().host();
    let device = output_device(&host, "STEPPED").unwrap();
    assert_eq!(device.id().unwrap().to_string(), "custom:stepped");
    let error = output_device(&host, "headphones").err().unwrap();
    assert!(error.to_string().contains("custom:stepped"), "{error}");
}

#[test]
fn devices_are_listed_with_their_capabilities() {
    let devices = list_devices(&Bench::default().host()).unwrap();
    assert_eq!(devices.len(), 1);
    assert_eq!(devices[0].id, "custom:stepped");
    assert_eq!(devices[0].name, "stepped card");
    assert!(devices[0].is_raw);
    assert!(devices[0].is_sound_card);
    let input = devices[0].offer(StreamDirection::Input).unwrap();
    let capabilities = input.capabilities();
    let formats: Vec<&str> = capabilities.iter().map(|c| c.format.as_str()).collect();
    assert_eq!(formats, ["f32", "i32", "i24", "i16"]);
}

/// FAULTS 4: a machine without sound is an error that the program reports; no library prints it.
/// Fault 4.
#[test]
fn a_machine_without_sound_is_refused_without_a_panic_or_a_print() {
    const CHILD: &str = "SIGNALGEN_TEST_NO_SOUND";
    if let Some(host) = std::env::var_os(CHILD) {
        let choice = match host.to_str() {
            Some("jack") => HostChoice::Jack,
            Some("alsa") => HostChoice::Alsa,
            _ => HostChoice::Default,
        };
        // ALSA may open without a configuration; then it has no such device.
        let result = open_host(choice).and_then(|host| {
            open_duplex(
                &host,
                &config(StreamFormat::F32),
                Generator::new(settings()),
                None,
            )
        });
        let error = result.unwrap_err();
        let is_refusal = matches!(
            error,
            AudioError::HostUnavailable { .. } | AudioError::Device(ChoiceError::NoMatch { .. })
        );
        assert!(is_refusal, "{error}");
        return;
    }
    for host in ["default", "alsa", "jack"] {
        let child = process::Command::new(std::env::current_exe().unwrap())
            .args([
                "--exact",
                "duplex::devices_refused::a_machine_without_sound_is_refused_without_a_panic_or_a_print",
                "--nocapture",
            ])
            .env(CHILD, host)
            .env("ALSA_CONFIG_PATH", "/nonexistent/alsa.conf")
            .env("JACK_DEFAULT_SERVER", "signalgen-test-no-such-server")
            .env("JACK_NO_START_SERVER", "1")
            .output()
            .unwrap();
        let stderr = String::from_utf8_lossy(&child.stderr);
        let stdout = String::from_utf8_lossy(&child.stdout);
        assert!(child.status.success(), "{host}: {stdout}{stderr}");
        assert!(stdout.contains("1 passed"), "{host}: {stdout}");
        assert_eq!(stderr, "", "{host}");
    }
}
