//! Who may have what.

use crate::described::Described;
use crate::hub::Hub;
use crate::session::{self, MAX_MESSAGE_BYTES};
use crate::site::Site;
use crate::token::Token;
use axum::Router;
use axum::body::Bytes;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::ws::rejection::WebSocketUpgradeRejection;
use axum::extract::{Path, State};
use axum::http::header::{self, HeaderMap, HeaderName, HeaderValue};
use axum::http::{StatusCode, Uri};
use axum::middleware::map_response;
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use std::sync::Arc;
use tokio::sync::Semaphore;
use tokio::task::spawn_blocking;

/// What requests are answered from.
pub(crate) struct Served {
    pub(crate) token: Token,
    pub(crate) site: Site,
    pub(crate) described: Described,
    pub(crate) hub: Arc<Hub>,
    pub(crate) free_sessions: Arc<Semaphore>,
}

/// Why there is no answer: a status and a sentence.
type Refusal = (StatusCode, &'static str);

const NO_TOKEN: Refusal =
    (StatusCode::FORBIDDEN, "The link needs the token that slabsplat serve has printed.\n");
const FOREIGN: Refusal =
    (StatusCode::FORBIDDEN, "A page from elsewhere may not look at this scene.\n");
const FULL: Refusal =
    (StatusCode::SERVICE_UNAVAILABLE, "As many look at this scene as the server has room for.\n");
const NOT_FOUND: Refusal = (StatusCode::NOT_FOUND, "There is no such thing here.\n");
const FAILED: Refusal = (StatusCode::INTERNAL_SERVER_ERROR, "This could not be made.\n");

/// Whatever a page of this server loads comes from this server.
const POLICY: &str = "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; img-src 'self' data: blob:; \
                      object-src 'none'; base-uri 'none'; form-action 'none'";

/// What every answer says.
const HEADERS: [(HeaderName, &str); 4] = [
    (header::CONTENT_SECURITY_POLICY, POLICY),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    // The link has the token.
    (header::REFERRER_POLICY, "no-referrer"),
    (header::CACHE_CONTROL, "no-cache"),
];

pub(crate) fn router(served: Arc<Served>) -> Router {
    let with_headers = async |mut response: Response| {
        let headers = HEADERS.map(|(name, value)| (name, HeaderValue::from_static(value)));
        response.headers_mut().extend(headers);
        response
    };
    Router::new()
        .route("/session", get(session))
        .route("/overview/{layer_idx}", get(overview))
        .route("/frames", get(frames))
        .fallback_service(get(file).with_state(served.clone()))
        .layer(map_response(with_headers))
        .with_state(served)
}

async fn file(State(served): State<Arc<Served>>, uri: Uri) -> Result<Response, Refusal> {
    let file = served.site.file(uri.path()).ok_or(NOT_FOUND)?;
    Ok(([(header::CONTENT_TYPE, file.mime)], file.bytes.clone()).into_response())
}

async fn session(State(served): State<Arc<Served>>, uri: Uri) -> Result<Response, Refusal> {
    served.check_token(&uri)?;
    let bytes = spawn_blocking(move || served.described.session()).await.map_err(|_| FAILED)?;
    Ok(data("application/json", bytes))
}

async fn overview(
    State(served): State<Arc<Served>>,
    Path(layer_idx): Path<String>,
    uri: Uri,
) -> Result<Response, Refusal> {
    served.check_token(&uri)?;
    let layer_idx = layer_idx.parse().map_err(|_| NOT_FOUND)?;
    let made = spawn_blocking(move || served.described.overview(layer_idx)).await;
    let bytes = made.map_err(|_| FAILED)?.ok_or(NOT_FOUND)?;
    Ok(data("application/octet-stream", bytes))
}

fn data(mime: &'static str, bytes: Bytes) -> Response {
    ([(header::CONTENT_TYPE, mime)], bytes).into_response()
}

async fn frames(
    State(served): State<Arc<Served>>,
    uri: Uri,
    headers: HeaderMap,
    upgrade: Result<WebSocketUpgrade, WebSocketUpgradeRejection>,
) -> Result<Response, Response> {
    let refused = |refusal: Refusal| refusal.into_response();
    served.check_token(&uri).map_err(refused)?;
    if !is_from_here(&headers) {
        return Err(refused(FOREIGN));
    }
    let upgrade = upgrade.map_err(IntoResponse::into_response)?;
    let place = served.free_sessions.clone().try_acquire_owned();
    let place = place.map_err(|_| refused(FULL))?;
    let hub = served.hub.clone();
    let upgrade = upgrade.max_message_size(MAX_MESSAGE_BYTES).max_frame_size(MAX_MESSAGE_BYTES);
    Ok(upgrade.on_upgrade(async move |socket| {
        session::run(socket, hub).await;
        drop(place);
    }))
}

impl Served {
    fn check_token(&self, uri: &Uri) -> Result<(), Refusal> {
        if self.token.is_in(uri.query()) { Ok(()) } else { Err(NO_TOKEN) }
    }
}

/// Whether a page of this server asks, or no page at all. A browser says which page it is, and lets any page
/// open a WebSocket.
fn is_from_here(headers: &HeaderMap) -> bool {
    let Some(origin) = headers.get(header::ORIGIN) else { return true };
    let host = headers.get(header::HOST).map(HeaderValue::as_bytes);
    let origin = origin.as_bytes();
    let of_origin = origin.strip_prefix(b"http://").or_else(|| origin.strip_prefix(b"https://"));
    of_origin.is_some() && of_origin == host
}
