//! The promises of the backend contract that need no judge, on every backend.

use slabsplat_backend::conformance;
use slabsplat_tests::render::{backends, open, validation_messages};

#[test]
fn backends_conform() {
    for name in backends() {
        conformance::check(&mut *open(name));
        let messages = validation_messages();
        assert!(messages.is_empty(), "{name}: {}", messages.join("\n"));
    }
}
