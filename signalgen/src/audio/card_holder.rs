//! Program that holds a busy sound card, from Linux' `/proc/asound`.

use std::fs;
use std::path::Path;

use crate::stream_health::StreamDirection;

/// Program names of sound servers, which hold every card that they find.
const SERVERS: [&str; 5] = ["pipewire", "wireplumber", "pulseaudio", "jackd", "jackdbus"];

/// Returns the program that holds a device, by its id such as `alsa:hw:CARD=USB,DEV=0`, as text for an operator.
pub(super) fn words(id: &str, direction: StreamDirection) -> String {
    match program(Path::new("/proc"), id, direction) {
        Some(program) if SERVERS.contains(&program.name.as_str()) => format!(
            "the sound server {program} holds it; set the card's profile to \"off\" there, or stop the server"
        ),
        Some(program) => format!("{program} holds it; end that one first"),
        None => "another program holds it: a sound server (PipeWire, PulseAudio, JACK) that must release the card, or \
                 another session; `fuser -v /dev/snd/*` lists them"
            .to_owned(),
    }
}

/// A program that holds a card.
#[derive(Debug, PartialEq, Eq)]
struct Program {
    name: String,
    process: u32,
}

impl std::fmt::Display for Program {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} (process {})", self.name, self.process)
    }
}

/// Returns the owner from the card's status files; `None` if they cannot be read or name no owner.
fn program(proc: &Path, id: &str, direction: StreamDirection) -> Option<Program> {
    let (_, arguments) = id.strip_prefix("alsa:")?.split_once(':')?;
    let mut parts = arguments.split(',');
    let card = parts.next()?;
    let card = card.strip_prefix("CARD=").unwrap_or(card);
    let device = parts.next().unwrap_or("0");
    let device = device.strip_prefix("DEV=").unwrap_or(device);
    let plain = |text: &str| {
        let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        !text.is_empty() && text.chars().all(is_plain)
    };
    if !plain(card) || !plain(device) {
        return None;
    }
    let card = if card.chars().all(|c| c.is_ascii_digit()) {
        format!("card{card}")
    } else {
        card.to_owned()
    };
    let way = match direction {
        StreamDirection::Output => 'p',
        StreamDirection::Input => 'c',
    };
    let streams = proc
        .join("asound")
        .join(card)
        .join(format!("pcm{device}{way}"));
    let owner = fs::read_dir(streams).ok()?.flatten().find_map(|stream| {
        let status = fs::read_to_string(stream.path().join("status")).ok()?;
        let line = status.lines().find(|line| line.starts_with("owner_pid"))?;
        line.split_once(':')?.1.trim().parse::<u32>().ok()
    })?;
    let of_owner = |file: &str| fs::read_to_string(proc.join(owner.to_string()).join(file)).ok();
    // The owner is a thread; operators know the program.
    let process = of_owner("status")
        .and_then(|status| {
            let line = status
                .lines()
                .find(|line| line.starts_with("Tgid:"))?
                .to_owned();
            line.split_once(':')?.1.trim().parse().ok()
        })
        .unwrap_or(owner);
    let name = fs::read_to_string(proc.join(process.to_string()).join("comm")).ok()?;
    Some(Program {
        name: name.trim().to_owned(),
        process,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a `/proc` in which thread 4711 of process 4700, `pipewire`, plays on a card.
    fn proc() -> tempfile::TempDir {
        let proc = tempfile::tempdir().unwrap();
        let write = |path: &str, text: &str| {
            let path = proc.path().join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        };
        write("asound/card2/pcm0p/sub0/status", "closed\n");
        write(
            "asound/card2/pcm0p/sub1/status",
            "state: RUNNING\nowner_pid   : 4711\ntrigger_time: 1.0\n",
        );
        write("asound/card2/pcm0c/sub0/status", "closed\n");
        write(
            "4711/status",
            "Name:\tdata-loop.0\nTgid:\t4700\nPid:\t4711\n",
        );
        write("4700/comm", "pipewire\n");
        #[cfg(unix)]
        std::os::unix::fs::symlink("card2", proc.path().join("asound/USB")).unwrap();
        proc
    }

    /// Fault 5.
    #[cfg(unix)]
    #[test]
    fn the_program_that_plays_on_a_card_is_found_by_its_name() {
        let proc = proc();
        let find = |id, direction| program(proc.path(), id, direction);
        for id in ["alsa:hw:CARD=USB,DEV=0", "alsa:plughw:2,0", "alsa:hw:2"] {
            let holder = find(id, StreamDirection::Output).unwrap();
            assert_eq!(holder.to_string(), "pipewire (process 4700)", "{id}");
            assert!(SERVERS.contains(&&*holder.name));
        }
        assert_eq!(
            find("alsa:hw:2", StreamDirection::Input),
            None,
            "nobody records"
        );
        for id in [
            "alsa:hw:2,1",
            "alsa:hw:../..",
            "alsa:default",
            "jack:system",
            "alsa:hw:",
        ] {
            assert_eq!(find(id, StreamDirection::Output), None, "{id}");
        }
    }
}
