//! `slabsplat backends`: what this machine has to render on.

use crate::{columns, stats, terminal};
use anyhow::Result;
use clap::Args;
use serde_json::{Value, json};
use slabsplat::{Caps, Choice, FoundBackend, FoundDevice, choose_backend, found_backends};

/// Tell which backends there are, on which devices, and which one auto takes
#[derive(Args)]
pub(crate) struct BackendsArgs {
    /// Answer in JSON
    #[arg(long)]
    json: bool,
}

const HEADER: [&str; 7] =
    ["backend", "device", "driver", "kind", "largest binding", "memory", "timed"];

pub(crate) fn run(args: &BackendsArgs) -> Result<()> {
    let found = found_backends();
    let auto = taken_by_auto();
    let text =
        if args.json { format!("{:#}\n", json_of(&found, &auto)) } else { text_of(&found, &auto) };
    terminal::answer(&text)
}

/// What `auto` opens, or why it opens nothing.
fn taken_by_auto() -> Result<Caps, String> {
    let Choice { backend, notes, .. } =
        choose_backend("auto").map_err(|error| error.to_string())?;
    terminal::warn_all(&notes);
    Ok(backend.caps().clone())
}

fn text_of(found: &[FoundBackend], auto: &Result<Caps, String>) -> String {
    let mut rows = vec![HEADER.map(str::to_owned)];
    let mut missing = String::new();
    for FoundBackend { name, devices, .. } in found {
        match devices {
            Ok(devices) => rows.extend(devices.iter().map(|device| row(name, device))),
            Err(reason) => missing += &format!("{name} is not available: {reason}\n"),
        }
    }
    let auto = match auto {
        Ok(caps) => format!("auto takes {}\n", stats::executor(caps)),
        Err(reason) => format!("auto takes none: {reason}\n"),
    };
    columns::aligned(&rows) + &missing + &auto
}

fn row(backend: &str, device: &FoundDevice) -> [String; 7] {
    let bytes = |n_bytes: Option<u64>| n_bytes.map_or("-".to_owned(), columns::bytes);
    [
        backend.to_owned(),
        device.name.clone(),
        device.driver.clone().unwrap_or("-".to_owned()),
        device.kind.to_owned(),
        bytes(device.max_binding_bytes),
        bytes(device.memory_bytes),
        if device.is_timed { "yes" } else { "no" }.to_owned(),
    ]
}

fn json_of(found: &[FoundBackend], auto: &Result<Caps, String>) -> Value {
    let auto = auto.as_ref().ok();
    json!({
        "backends": found.iter().map(backend_json).collect::<Vec<_>>(),
        "auto": auto.map(|caps| json!({ "backend": caps.name, "device": caps.device })),
    })
}

fn backend_json(backend: &FoundBackend) -> Value {
    let devices = backend.devices.as_deref().unwrap_or_default();
    json!({
        "name": backend.name,
        "devices": devices.iter().map(device_json).collect::<Vec<_>>(),
        "unavailable": backend.devices.as_ref().err(),
    })
}

fn device_json(device: &FoundDevice) -> Value {
    json!({
        "name": device.name,
        "driver": device.driver,
        "kind": device.kind,
        "max_binding_bytes": device.max_binding_bytes,
        "memory_bytes": device.memory_bytes,
        "timestamps": device.is_timed,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat::Method;

    fn card() -> FoundDevice {
        let mut card = FoundDevice::new("Fake 3000", "discrete");
        card.driver = Some("fake 1.0".to_owned());
        card.max_binding_bytes = Some(1 << 31);
        card.is_timed = true;
        card
    }

    fn found() -> [FoundBackend; 2] {
        [
            FoundBackend::new("ash", Ok(vec![card()])),
            FoundBackend::new("wgpu", Err("there is no driver".to_owned())),
        ]
    }

    #[test]
    fn backends_text() {
        let caps = Caps::new("ash", "Fake 3000", Method::ALL);
        let expected = "\
backend  device     driver    kind      largest binding  memory  timed
ash      Fake 3000  fake 1.0  discrete  2.0 GiB          -       yes
wgpu is not available: there is no driver
auto takes ash on Fake 3000
";
        assert_eq!(text_of(&found(), &Ok(caps)), expected);
        let text = text_of(&found(), &Err("nothing opens".to_owned()));
        assert!(text.ends_with("auto takes none: nothing opens\n"), "{text}");
    }

    #[test]
    fn backends_json() {
        let answer = json_of(&found(), &Err(String::new()));
        assert_eq!(answer["auto"], Value::Null);
        assert_eq!(answer["backends"][0]["devices"][0]["max_binding_bytes"], 2_147_483_648_u64);
        assert_eq!(answer["backends"][0]["unavailable"], Value::Null);
        assert_eq!(answer["backends"][1]["unavailable"], "there is no driver");
    }
}
