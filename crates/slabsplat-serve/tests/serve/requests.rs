//! Who is let in, and what is served to whom.

use crate::client::{Viewer, block_on, get, started};
use slabsplat_serve::{ServeConfig, ServeError, serve};
use std::fs;

#[test]
fn wrong_tokens_are_refused() {
    let server = started(ServeConfig::default());
    assert!(server.url().ends_with("/?token=secret"), "{}", server.url());
    for path in ["/session", "/overview/0", "/overview/9", "/frames"] {
        for query in ["", "?token=", "?token=secre", "?token=secret1", "?tokens=secret"] {
            let (status, _, body) = get(&server, &format!("{path}{query}"));
            assert_eq!(status, 403, "{path}{query}");
            let body = String::from_utf8(body).unwrap();
            assert!(body.lines().count() == 1 && body.contains("token"), "{body}");
        }
    }
    assert_eq!(block_on(Viewer::refusal(&server, "wrong", None)), 403);
    let random = serve(crate::client::opened(), ServeConfig::default()).unwrap();
    let (_, token) = random.url().split_once("?token=").unwrap();
    assert!(token.len() == 32 && get(&random, &format!("/session?token={token}")).0 == 200);
}

#[test]
fn foreign_pages_are_refused() {
    let server = started(ServeConfig::default());
    let (address, port) = (server.address(), server.address().port());
    block_on(async {
        for origin in [
            "http://evil.example".to_owned(),
            format!("http://evil.example:{port}"),
            format!("http://{address}.evil.example"),
            format!("ftp://{address}"),
            address.to_string(),
            "null".to_owned(),
        ] {
            assert_eq!(Viewer::refusal(&server, "secret", Some(&origin)).await, 403, "{origin}");
        }
        for origin in [format!("http://{address}"), format!("https://{address}")] {
            let viewer = Viewer::try_connect(&server, "secret", Some(&origin)).await;
            assert!(viewer.is_ok(), "{origin}");
        }
    });
}

#[test]
fn sessions_are_limited() {
    let server = started(ServeConfig::default().max_sessions(2));
    block_on(async {
        let (a, _b) = (Viewer::connect(&server).await, Viewer::connect(&server).await);
        assert_eq!(Viewer::refusal(&server, "secret", None).await, 503);
        drop(a);
        // It is noticed when the system says so.
        while Viewer::try_connect(&server, "secret", None).await.is_err() {
            tokio::task::yield_now().await;
        }
    });
}

#[test]
fn site_is_served_and_nothing_beside_it() {
    let dir = tempfile::tempdir().unwrap();
    let site = dir.path().join("site");
    fs::create_dir_all(site.join("pkg")).unwrap();
    fs::write(dir.path().join("secret.txt"), "outside").unwrap();
    for (name, text) in [("index.html", "<p>here"), ("pkg/a.wasm", "w"), ("a.js", "1")] {
        fs::write(site.join(name), text).unwrap();
    }
    let server = started(ServeConfig::default().site(&site));
    for (path, mime, text) in [
        ("/", "text/html", "<p>here"),
        ("/?token=secret", "text/html", "<p>here"),
        ("/pkg/a.wasm", "application/wasm", "w"),
        ("/a.js?v=1", "text/javascript", "1"),
    ] {
        let (status, head, body) = get(&server, path);
        assert_eq!((status, body.as_slice()), (200, text.as_bytes()), "{path}");
        for header in [
            &format!("content-type: {mime}"),
            "content-security-policy: default-src 'self'; script-src 'self' 'wasm-unsafe-eval'",
            "x-content-type-options: nosniff",
            "cache-control: no-cache",
        ] {
            assert!(head.contains(header), "{path}: {header}: {head}");
        }
    }
    for path in [
        "/../secret.txt",
        "/pkg/../../secret.txt",
        "/%2e%2e/secret.txt",
        "/..%2fsecret.txt",
        "/..\\secret.txt",
        "//etc/passwd",
        "/pkg",
        "/pkg/",
    ] {
        assert_eq!(get(&server, path).0, 404, "{path}");
    }
    let (status, _, body) = get(&started(ServeConfig::default()), "/");
    assert!(status == 200 && String::from_utf8_lossy(&body).contains("cargo xtask web"));
}

#[test]
fn config_errors_say_what_is_wrong() {
    let failed = |config: ServeConfig| {
        serve(crate::client::opened(), config).expect_err("it cannot be").to_string()
    };
    assert!(failed(ServeConfig::default().token("a b")).contains("a token is 1 to 128"));
    assert!(failed(ServeConfig::default().site("/nowhere")).contains("page from /nowhere: "));
    let server = started(ServeConfig::default());
    let taken =
        serve(crate::client::opened(), ServeConfig::default().port(server.address().port()));
    assert!(matches!(taken, Err(ServeError::Listen { .. })));
}
