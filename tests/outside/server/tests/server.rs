//! Requests and answers, without a socket.

use axum::Router;
use axum::body::Body;
use axum::http::{Request, StatusCode};
use http_body_util::BodyExt;
use slabsplat::io;
use tower::ServiceExt;

fn service() -> Router {
    server::router(io::builtin_volume("neuron", Some(24)).unwrap()).unwrap()
}

async fn get(service: &Router, path: &str) -> (StatusCode, Vec<u8>) {
    let request = Request::builder().uri(path).body(Body::empty()).unwrap();
    let answer = service.clone().oneshot(request).await.unwrap();
    let status = answer.status();
    (status, answer.into_body().collect().await.unwrap().to_bytes().to_vec())
}

#[tokio::test]
async fn answers_with_the_picture_that_was_asked_for() {
    let service = service();
    let (status, front) = get(&service, "/picture.png?size=40").await;
    assert_eq!(status, StatusCode::OK);
    assert!(front.starts_with(b"\x89PNG"), "a picture");
    assert_eq!(&front[16..24], [0, 0, 0, 40, 0, 0, 0, 40], "its width and height");
    let (_, again) = get(&service, "/picture.png?size=40&turn=0").await;
    assert_eq!(front, again);
    let (_, turned) = get(&service, "/picture.png?size=40&turn=50").await;
    assert_ne!(front, turned, "from another side");
}

#[tokio::test]
async fn refuses_what_makes_no_sense() {
    let service = service();
    for wish in ["size=0", "size=9000", "turn=NaN", "turn=left", "tilt=3"] {
        let (status, _) = get(&service, &format!("/picture.png?{wish}")).await;
        assert_eq!(status, StatusCode::BAD_REQUEST, "{wish}");
    }
}

#[tokio::test]
async fn many_at_once() {
    let service = service();
    let wishes: Vec<String> =
        (0..8).map(|i| format!("/picture.png?size=32&turn={}", 45 * i)).collect();
    let answers = wishes.iter().map(|wish| {
        let service = service.clone();
        let wish = wish.clone();
        tokio::spawn(async move { get(&service, &wish).await })
    });
    for answer in answers.collect::<Vec<_>>() {
        assert_eq!(answer.await.unwrap().0, StatusCode::OK);
    }
}
