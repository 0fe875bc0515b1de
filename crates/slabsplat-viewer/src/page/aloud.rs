//! What the viewer says, as text of the page: egui draws letters that only eyes can read, and a screen reader
//! takes them from an element.

use crate::app::Viewer;
use eframe::egui::Ui;
use web_sys::{Element, window};

/// The element that has the text, where a page has one; `role="status"` has it read out.
const ELEMENT: &str = "said";

/// A viewer whose messages are text of the page.
pub(super) struct Aloud {
    viewer: Viewer,
    element: Option<Element>,
    said: String,
}

impl Aloud {
    pub(super) fn new(viewer: Viewer) -> Self {
        let document = window().and_then(|window| window.document());
        let element = document.and_then(|document| document.get_element_by_id(ELEMENT));
        Self { viewer, element, said: String::new() }
    }
}

impl eframe::App for Aloud {
    fn ui(&mut self, ui: &mut Ui, frame: &mut eframe::Frame) {
        self.viewer.ui(ui, frame);
        let says = self.viewer.says();
        if let Some(element) = self.element.as_ref().filter(|_| says != self.said) {
            element.set_text_content(Some(&says));
            self.said = says;
        }
    }
}
