//! Signals that end a program: the current work stops, and finished work is kept.

use std::io;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, LazyLock};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

/// The signal that came; 0 before.
static RECEIVED: LazyLock<Arc<AtomicUsize>> = LazyLock::new(Arc::default);

#[cfg(unix)]
const SIGNALS: [i32; 3] = [SIGINT, SIGTERM, signal_hook::consts::SIGHUP];
#[cfg(not(unix))]
const SIGNALS: [i32; 2] = [SIGINT, SIGTERM];

/// Returns true if a signal to end came since [`install_handlers`].
pub fn interrupted() -> bool {
    RECEIVED.load(Ordering::Relaxed) != 0
}

/// Returns the exit code of a program that a signal has ended: 128 plus the signal's number, as in
/// shells, that is 130 after Ctrl-C, 143 after SIGTERM, 129 after SIGHUP.
pub fn exit_code() -> Option<u8> {
    let signal = RECEIVED.load(Ordering::Relaxed);
    (signal != 0).then(|| 128u8.saturating_add(u8::try_from(signal).unwrap_or(127)))
}

/// Makes Ctrl-C, SIGTERM and SIGHUP end the current work, and a second Ctrl-C the program. A signal
/// that the program was started to ignore (`nohup`) stays ignored.
pub fn install_handlers() {
    let again = Arc::new(AtomicBool::new(false));
    for signal in SIGNALS.into_iter().filter(|&signal| !is_ignored(signal)) {
        if let Err(error) = register(signal, &again) {
            eprintln!("warning: signal {signal} will end the program without writing ({error})");
        }
    }
}

/// Registers a signal. A session's end sends SIGTERM and SIGHUP together, so only a second Ctrl-C,
/// which a person sends, ends the program at once.
fn register(signal: i32, again: &Arc<AtomicBool>) -> io::Result<()> {
    if signal == SIGINT {
        flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(again))?;
        flag::register(signal, Arc::clone(again))?;
    }
    flag::register_usize(signal, Arc::clone(&RECEIVED), signal as usize)?;
    Ok(())
}

/// Returns true if the program was started with this signal ignored, where the system tells it
/// (proc(5)).
pub fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status
        .lines()
        .find_map(|line| line.strip_prefix("SigIgn:"))
        .and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}
