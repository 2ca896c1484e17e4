//! Time of analyses of a recording in memory: `arrays FOLDER THREADS CALLS` prints the seconds that each thread's calls take together.
//! `./dev bench --python` compares them with those of Python.

#![expect(clippy::print_stdout, reason = "another program reads it")]

use std::error::Error;
use std::path::Path;
use std::thread;
use std::time::Instant;

use analysis::Settings;
use recording::recorded_arrays::{Readings, RecordedArrays, Samples};
use recording::{RecordingReader, RecordingSource};
use study::provenance::StatedProvenance;
use study_analysis::StudyAnalysis;

/// Frames read at a time.
const BLOCK_FRAMES: usize = 16_384;

fn main() -> Result<(), Box<dyn Error>> {
    // `cargo bench` passes an option of its own to each benchmark.
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| a != "--bench")
        .collect();
    let [folder, threads, calls] = &arguments[..] else {
        return Ok(());
    };
    let (threads, calls): (usize, usize) = (threads.parse()?, calls.parse()?);
    let mut reader = RecordingReader::open(Path::new(folder))?;
    let signals = reader.manifest().signals().ok_or("no signals")?;
    let indices = [signals.channels.drive.index, signals.channels.pickup.index];
    let channels = usize::from(reader.format().channels);
    let mut block = Vec::new();
    let mut samples: [Vec<f32>; 2] = Default::default();
    while reader.read_block(BLOCK_FRAMES, &mut block)? > 0 {
        for (samples, index) in samples.iter_mut().zip(indices) {
            samples.extend(block.iter().skip(usize::from(index)).step_by(channels));
        }
    }
    let force = reader.force()?.collect::<Result<Vec<_>, _>>()?;
    let position = reader.position()?.collect::<Result<Vec<_>, _>>()?;
    let force_s: Vec<f64> = force.iter().map(|row| row.time_s).collect();
    let normal: Vec<f64> = force.iter().map(|row| row.normal_n).collect();
    let lateral: Vec<f64> = force.iter().map(|row| row.lateral_n).collect();
    let position_s: Vec<f64> = position.iter().map(|row| row.time_s).collect();
    let position_m: Vec<f64> = position.iter().map(|row| row.position_m).collect();
    let manifest = reader.manifest().clone();
    let sample_rate_hz = reader.format().sample_rate_hz;
    let analyse = || -> Result<(), Box<dyn Error>> {
        let readings = |time_s, values| Some(Readings { time_s, values });
        let [drive, pickup] = samples.each_ref().map(|samples| Samples::Single(samples));
        let arrays = RecordedArrays::new(manifest.clone(), sample_rate_hz, [drive, pickup])?
            .with_forces(readings(&force_s, &normal), readings(&force_s, &lateral))
            .with_position(readings(&position_s, &position_m));
        let source = RecordingSource::arrays(&arrays);
        StudyAnalysis::in_memory(&source, &Settings::default(), StatedProvenance::default())?;
        Ok(())
    };
    analyse()?;
    let started = Instant::now();
    let is_done = thread::scope(|scope| {
        let work = || (0..calls).all(|_| analyse().is_ok());
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        workers
            .into_iter()
            .all(|worker| worker.join().is_ok_and(|is_done| is_done))
    });
    if !is_done {
        return Err("an analysis failed".into());
    }
    println!("{}", started.elapsed().as_secs_f64());
    Ok(())
}
