//! The listings of the guide, which run as tests of the documentation.

macro_rules! chapters {
    ($($name:ident = $path:literal),* $(,)?) => {
        $(#[doc = include_str!(concat!("../../docs/guide/src/", $path))] mod $name {})*
    };
}

chapters! {
    tour = "tour.md",
    concepts = "concepts.md",
    methods = "methods.md",
    own_data = "own-data.md",
    scenes_as_text = "scenes-as-text.md",
    pictures = "pictures.md",
    films = "films.md",
    viewer = "viewer.md",
    windows = "windows.md",
    browsers = "browsers.md",
    serve = "serve.md",
    own_kernel = "own-kernel.md",
    own_backend = "own-backend.md",
    performance = "performance.md",
    api = "api.md",
}
