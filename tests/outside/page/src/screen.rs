//! The canvas, the words below it, and the address above.

use slabsplat::{Caps, Image};
use std::error::Error;
use std::str::FromStr;
use wasm_bindgen::{Clamped, JsCast, JsValue};
use wasm_bindgen_futures::JsFuture;
use web_sys::{CanvasRenderingContext2d, HtmlCanvasElement, ImageData, UrlSearchParams, Window};

/// Where pictures are shown.
pub(crate) struct Screen {
    pub(crate) canvas: HtmlCanvasElement,
    context: CanvasRenderingContext2d,
}

impl Screen {
    /// The canvas with the id `canvas`.
    pub(crate) fn of_page() -> Result<Self, Box<dyn Error>> {
        let element = window().document().and_then(|it| it.get_element_by_id("canvas"));
        let canvas: HtmlCanvasElement =
            element.ok_or("there is no canvas")?.dyn_into().map_err(|_| "it is no canvas")?;
        let side = asked_number("pixels", 384)?;
        canvas.set_width(side);
        canvas.set_height(side);
        let context = canvas.get_context("2d").map_err(error)?.ok_or("it has no context")?;
        let context = context.dyn_into().map_err(|_| "it is another context")?;
        Ok(Self { canvas, context })
    }

    /// Shows a picture, and says by what it was drawn.
    pub(crate) fn show(&self, image: &Image, by: &Caps, ms: f64) -> Result<(), Box<dyn Error>> {
        let rgba = image.to_rgba8();
        let data = ImageData::new_with_u8_clamped_array(Clamped(&rgba), image.width());
        self.context.put_image_data(&data.map_err(error)?, 0.0, 0.0).map_err(error)?;
        say(&format!("{ms:.0} ms by {} on {}", by.name, by.device));
        Ok(())
    }

    /// Until the browser is about to show what was drawn.
    pub(crate) async fn repainted(&self) -> Result<(), Box<dyn Error>> {
        let promise = js_sys::Promise::new(&mut |resolve, _| {
            // It fails in a page that is gone, where nobody waits any more.
            drop(window().request_animation_frame(&resolve));
        });
        JsFuture::from(promise).await.map(drop).map_err(error)
    }

    /// Milliseconds since some moment.
    pub(crate) fn now_ms(&self) -> f64 {
        window().performance().map_or(f64::NAN, |clock| clock.now())
    }
}

/// Says something below the canvas.
pub(crate) fn say(words: &str) {
    let note = window().document().and_then(|it| it.get_element_by_id("note"));
    if let Some(note) = note {
        note.set_text_content(Some(words));
    }
}

/// What the address says of that name, as in `?name=value`.
pub(crate) fn asked(name: &str) -> Option<String> {
    let search = window().location().search().ok()?;
    UrlSearchParams::new_with_str(&search).ok()?.get(name)
}

/// The number that the address says of that name, or the one that there is by default.
pub(crate) fn asked_number<T: FromStr>(name: &str, default: T) -> Result<T, Box<dyn Error>> {
    let parse =
        |text: String| text.parse().map_err(|_| format!("{name} is {text}, no such number"));
    Ok(asked(name).map_or(Ok(default), parse)?)
}

/// What JavaScript threw.
pub(crate) fn error(thrown: impl Into<JsValue>) -> Box<dyn Error> {
    format!("{:?}", thrown.into()).into()
}

fn window() -> Window {
    web_sys::window().expect("a page has a window")
}
