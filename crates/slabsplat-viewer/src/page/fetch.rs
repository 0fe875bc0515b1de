//! Bytes that come into a page, and files that leave it.

use eframe::wasm_bindgen::{JsCast, JsValue};
use js_sys::{Array, Uint8Array};
use wasm_bindgen_futures::JsFuture;
use web_sys::{Blob, BlobPropertyBag, HtmlAnchorElement, Response, Url, window};

/// What a server has under an address.
pub(crate) async fn bytes_of(url: &str) -> Result<Vec<u8>, String> {
    let fetched = async {
        let window = window().ok_or(JsValue::NULL)?;
        let response: Response = JsFuture::from(window.fetch_with_str(url)).await?.dyn_into()?;
        let bytes = JsFuture::from(response.array_buffer()?).await?;
        Ok::<_, JsValue>((response.ok(), response.status(), Uint8Array::new(&bytes).to_vec()))
    };
    match fetched.await {
        Ok((true, _, bytes)) => Ok(bytes),
        // A server of ours says why in a sentence.
        Ok((false, status, bytes)) => match String::from_utf8(bytes) {
            Ok(why) if !why.is_empty() && why.len() < 300 => Err(why),
            _ => Err(format!("{url}: the server answers {status}")),
        },
        Err(_) => Err(format!("{url} cannot be fetched: is it there, and may this page read it?")),
    }
}

/// Gives the user a file.
pub(crate) fn download(name: &str, bytes: &[u8]) -> Result<(), String> {
    let given = || {
        let parts = Array::of1(&Uint8Array::from(bytes));
        let options = BlobPropertyBag::new();
        options.set_type("application/octet-stream");
        let blob = Blob::new_with_u8_array_sequence_and_options(&parts, &options)?;
        let url = Url::create_object_url_with_blob(&blob)?;
        let document = window().and_then(|window| window.document()).ok_or(JsValue::NULL)?;
        let link: HtmlAnchorElement = document.create_element("a")?.dyn_into()?;
        link.set_href(&url);
        link.set_download(name);
        link.click();
        Url::revoke_object_url(&url)
    };
    given().map_err(|error: JsValue| format!("{name} cannot be saved: {error:?}"))
}
