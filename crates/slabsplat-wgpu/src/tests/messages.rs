//! Collects what wgpu and the validation layers complain about, of all tests together.

use std::sync::{Mutex, Once};

/// Older layers do not know WGSL as a language that shaders come from.
const FALSE_ALARM: &str = "Invalid source language operand: 10";

static MESSAGES: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// To be called before a device is opened: wgpu asks then which messages are wanted.
pub(super) fn install() {
    static INSTALLED: Once = Once::new();
    INSTALLED.call_once(|| {
        log::set_logger(&Collector).unwrap();
        log::set_max_level(log::LevelFilter::Warn);
    });
}

pub(super) fn collect(message: &str) {
    MESSAGES.lock().unwrap().push(message.to_owned());
}

/// All messages so far.
pub(super) fn all() -> Vec<String> {
    MESSAGES.lock().unwrap().clone()
}

struct Collector;

impl log::Log for Collector {
    fn enabled(&self, message: &log::Metadata<'_>) -> bool {
        message.level() <= log::Level::Warn && message.target().starts_with("wgpu")
    }

    fn log(&self, record: &log::Record<'_>) {
        let text = record.args().to_string();
        // A message of the validation is followed by a line for each object that it is about.
        let is_detail = text.trim_start().starts_with("objects:");
        if self.enabled(record.metadata()) && !text.contains(FALSE_ALARM) && !is_detail {
            collect(&format!("{}: {text}", record.target()));
        }
    }

    fn flush(&self) {}
}
