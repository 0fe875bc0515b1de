//! Writes the JavaScript between pages and their WebAssembly: what the program `wasm-bindgen` does, of just
//! the version that `Cargo.lock` has, and without a download.
//!
//! ```sh
//! cargo build --release --target wasm32-unknown-unknown --package page
//! cargo run --release --package bindgen -- FOLDER target/wasm32-unknown-unknown/release/page.wasm
//! ```

use std::path::PathBuf;
use std::process::ExitCode;

use wasm_bindgen_cli_support::Bindgen;

fn main() -> ExitCode {
    let paths: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let [folder, modules @ ..] = &paths[..] else {
        eprintln!("Usage: bindgen FOLDER MODULE.wasm …");
        return ExitCode::from(2);
    };
    for module in modules {
        let mut bindgen = Bindgen::new();
        // As the program has it: the module lies beside its JavaScript.
        bindgen.input_path(module).typescript(false).omit_default_module_path(false);
        if let Err(error) = bindgen.web(true).and_then(|bindgen| bindgen.generate(folder)) {
            eprintln!("error: {}: {error:#}", module.display());
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}
