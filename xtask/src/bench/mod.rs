//! `cargo xtask bench`: everything that measures time or work.
//!
//! [`criterion`] runs the benchmarks that crates have, [`peers`] compares whole frames with another renderer,
//! [`scaling`] shows how time grows, and [`instructions`] guards against growth unnoticed.
//! Only the last of them judges: times are printed with what they were measured on, and never asserted.

mod criterion;
pub(crate) mod instructions;
mod options;
mod peers;
mod program;
mod scaling;
mod table;

use std::ffi::OsString;

use anyhow::Result;

pub(crate) use criterion::Processor;

/// What is measured.
#[derive(Debug, PartialEq)]
pub(crate) enum Bench {
    /// With the arguments that cargo and criterion take.
    Criterion(Processor, Vec<OsString>),
    Peers(peers::Options),
    Scaling(scaling::Options),
    Instructions(instructions::Task),
}

/// The first word, if it is a kind of benchmark; a filter of that name stands after `--`.
pub(crate) fn parse(mut args: Vec<OsString>) -> Result<Bench, String> {
    let kind = args.first().and_then(|arg| arg.to_str()).unwrap_or_default().to_owned();
    let mut rest = || args.split_off(1);
    Ok(match kind.as_str() {
        "cpu" => Bench::Criterion(Processor::Cpu, rest()),
        "gpu" => Bench::Criterion(Processor::Gpu, rest()),
        "peers" => Bench::Peers(peers::parse(&rest())?),
        "scaling" => Bench::Scaling(scaling::parse(&rest())?),
        "instructions" => Bench::Instructions(instructions::parse(&rest())?),
        _ => Bench::Criterion(Processor::Any, args),
    })
}

pub(crate) fn run(bench: &Bench) -> Result<()> {
    match bench {
        Bench::Criterion(processor, args) => criterion::run(*processor, args),
        Bench::Peers(options) => peers::run(options),
        Bench::Scaling(options) => scaling::run(options),
        Bench::Instructions(task) => instructions::run(*task),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(args: &[&str]) -> Result<Bench, String> {
        parse(args.iter().map(OsString::from).collect())
    }

    #[test]
    fn parse_processors() {
        let check = |args: &[&str], processor: Processor, rest: &[&str]| {
            let rest = rest.iter().map(OsString::from).collect();
            assert_eq!(parsed(args), Ok(Bench::Criterion(processor, rest)), "arguments {args:?}");
        };
        check(&[], Processor::Any, &[]);
        check(&["--", "toss"], Processor::Any, &["--", "toss"]);
        check(&["cpu"], Processor::Cpu, &[]);
        check(&["gpu", "--", "sort"], Processor::Gpu, &["--", "sort"]);
        check(&["--", "gpu"], Processor::Any, &["--", "gpu"]);
    }

    #[test]
    fn parse_options() {
        let options = peers::Options { n_frames: 3, n_pairs: 7 };
        assert_eq!(parsed(&["peers", "--frames", "3", "--pairs", "7"]), Ok(Bench::Peers(options)));
        let record = Bench::Instructions(instructions::Task::Record);
        assert_eq!(parsed(&["instructions", "--record"]), Ok(record));
        for wrong in [["peers", "--frame"], ["scaling", "voxel"], ["instructions", "--recrod"]] {
            assert!(parsed(&wrong).is_err(), "{wrong:?}");
        }
    }
}
