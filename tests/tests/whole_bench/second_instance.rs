//! A second instance on the study or hardware of a first one: it is refused, and the first one continues.

use std::fs;
use std::time::Duration;

use bench_tests::program::bench;
use bench_tests::running::Running;
use bench_tests::session::{
    SOUND_CARD, finish, headless_run, text, write_bench_config, write_demo_protocol,
};
use config::Config;
use devices::claim::Claim;
use rustix::process::Signal;

use super::refusals::{ONE_TRIAL, assert_early_refusal, assert_refusal, room, uncalibrated};

const MINUTE: Duration = Duration::from_secs(60);

/// Fault 34.
#[test]
fn a_second_instance_on_the_same_study() {
    let (folder, study) = room();
    let protocol = write_demo_protocol(folder.path(), ONE_TRIAL);
    let mut first_run = headless_run(&study, "sub-01", protocol);
    let mut first_run = Running::start(&mut first_run, &folder.path().join("output"));
    let log = study.join("sub-01/ses-01/events.jsonl");
    let has_begun = first_run.wait_for(MINUTE, || log.is_file().then_some(()));
    assert!(has_begun.is_some(), "{}", first_run.output());
    // Pause the first one for as long as the second takes: in simulated time no watch notices.
    first_run.signal(Signal::STOP);
    let output = finish(&mut headless_run(&study, "sub-02", "demo"));
    assert_refusal(&output, &["in use", &first_run.pid().to_string()]);
    assert!(!study.join("sub-02").exists());
    assert!(first_run.exit_status().is_none());
    first_run.signal(Signal::CONT);
    assert!(first_run.wait(MINUTE).success(), "{}", first_run.output());
}

/// Fault 34.
/// Hazard 21.
#[test]
fn a_second_instance_on_the_same_hardware() {
    let (folder, study) = room();
    let folder_name = folder.path().file_name().unwrap().to_string_lossy();
    let card = format!("\"hw:CARD=Absent{folder_name}\"");
    let port = format!("\"{}\"", folder.path().join("port").display());
    let changes = [
        ("\"sim\"", &*card),
        ("\"sim\"", &*card),
        ("\"/dev/ttyUSB0\"", &*port),
        SOUND_CARD,
    ];
    let config = write_bench_config(folder.path(), &changes);
    // The test itself is the other instance: on the same card with another sensor, then on the same sensor with another card.
    let first_claim = |device: &str| {
        let text = fs::read_to_string(&config).unwrap();
        let config_text = text.replace(device, &device.replacen('"', "\"x", 1));
        Claim::take(&Config::parse(&config_text, "bench.toml").unwrap()).unwrap()
    };
    let holder = format!("(process {})", std::process::id());
    for (device, words) in [
        (&port, ["the sound card hw:CARD=Absent", &holder]),
        (&card, ["the force sensor's port", &holder]),
    ] {
        let claim = first_claim(device);
        let mut run = uncalibrated(&study, &config);
        assert_early_refusal(&mut run, &study, &words);
        let mut check = bench();
        check.args(["check", "--quick", "--config"]).arg(&config);
        let output = finish(&mut check);
        assert_eq!(output.status.code(), Some(1));
        let transcript = text(&output);
        assert!(
            transcript.contains("FAILED  hardware") && transcript.contains(words[0]),
            "{transcript}"
        );
        drop(claim);
    }
    // A simulated bench is never shared, whatever devices its configuration names.
    let simulated = folder.path().join("simulated");
    fs::create_dir(&simulated).unwrap();
    let simulated = write_bench_config(&simulated, &changes[2..3]);
    let config_text = fs::read_to_string(&simulated).unwrap();
    let claim =
        Claim::take(&Config::parse(&config_text.replace("\"sim\"", &card), "bench.toml").unwrap());
    let mut monitor = bench();
    monitor
        .args(["monitor", "--mock", "--headless", "--speed", "max"])
        .args(["--duration-s", "0.1", "--config"])
        .arg(&simulated);
    let output = finish(&mut monitor);
    assert!(output.status.success(), "{}", text(&output));
    drop(claim.unwrap());
    // The claim ends with its holder.
    let words = ["no output device matches", "hw:CARD=Absent"];
    let mut run = uncalibrated(&study, &config);
    assert_early_refusal(&mut run, &study, &words);
    for entry in fs::read_dir(devices::lock_folder().unwrap()).unwrap() {
        let path = entry.unwrap().path();
        let name = path.to_string_lossy().into_owned();
        if name.contains("friction-bench-") && name.contains(&*folder_name) {
            fs::remove_file(path).unwrap();
        }
    }
}
