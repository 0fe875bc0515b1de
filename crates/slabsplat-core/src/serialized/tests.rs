//! What is written is read back, with the keys of scene files.

use crate::{
    Camera, ImageDesc, Isosurface, LabelStyle, Light, Method, Mode, Phong, PiecewiseLinear, Plane,
    Projection, Region, RenderSettings, Shading, TransferBox, TransferFunction, TransferFunction2d,
    TransferImage,
};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt::Debug;

fn written<T: Serialize>(value: &T) -> String {
    toml::to_string(value).unwrap()
}

fn read<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    toml::from_str(text).map_err(|error| error.message().to_owned())
}

/// Writes a value, compares the keys, and reads it back.
fn check<T: Serialize + DeserializeOwned + Debug + PartialEq>(value: &T, expected: &str) {
    let text = written(value);
    assert_eq!(text, expected);
    assert_eq!(read::<T>(&text).as_ref(), Ok(value));
}

#[test]
fn serialized_values_come_back() {
    let parallel = Projection::Orthographic { view_height: 40.0 };
    let camera = Camera::new([90.0, 0.0, 0.5], [1.0; 3], [0.0, 0.0, 1.0], parallel).unwrap();
    check(
        &camera,
        "projection = \"orthographic\"\neye = [90.0, 0.0, 0.5]\ntarget = [1.0, 1.0, 1.0]\n\
         up = [0.0, 0.0, 1.0]\nview_height = 40.0\n",
    );
    let transfer =
        TransferFunction::new([(80.0, 0.0), (255.0, 0.9)], [(0.0, [0.25, 0.5, 1.0])]).unwrap();
    check(&transfer, "opacity = [[80.0, 0.0], [255.0, 0.9]]\ncolor = [[0.0, 0.25, 0.5, 1.0]]\n");
    let image = ImageDesc::new(64, 32).background([0.5, 0.0, 0.0, 1.0]);
    check(&image, "width = 64\nheight = 32\nbackground = [0.5, 0.0, 0.0, 1.0]\n");
    check(&Light::default(), "from = \"headlight\"\ncolor = [1.0, 1.0, 1.0]\n");
    let evening = Light::towards([0.0, -2.0, 0.0]).unwrap().color([1.0, 0.5, 0.25]);
    check(&evening, "from = [0.0, -1.0, 0.0]\ncolor = [1.0, 0.5, 0.25]\n");
    check(&Isosurface::new(80.0, 0.5, None).unwrap(), "value = 80.0\nopacity = 0.5\n");
    let corner = Region::in_box([[0.0; 3], [9.0, 8.0, 7.0]]).unwrap().inverted().lit();
    assert_eq!(read(&written(&corner)), Ok(corner));
    let settings = RenderSettings::default().method(Method::PostClassified).mode(Mode::Maximum);
    assert_eq!(read(&written(&settings)), Ok(settings));
    for shading in [Shading::None, Shading::Phong(Phong::default().diffuse(0.5))] {
        assert_eq!(read(&written(&shading)), Ok(shading));
    }
}

#[test]
fn serialized_transfer_functions_of_two_dimensions_come_back() {
    let part = TransferBox::new([0.1, 1.0 / 3.0], [2.0, f64::INFINITY]).unwrap();
    let any = TransferBox::new([0.0, 1.0], [f64::NEG_INFINITY, f64::INFINITY]).unwrap();
    let boxes = TransferFunction2d::Boxes(vec![part.fade([0.1, 0.0]).unwrap(), any]);
    assert_eq!(read(&written(&boxes)), Ok(boxes));
    assert!(!written(&any).contains("gradients"), "not every format has infinities");
    let pixels = vec![[0.1, 1.0 / 3.0, 0.0, 1.0]];
    let image = TransferImage::new(1, pixels, [0.0, 1.0], [-0.1, 7.0]).unwrap();
    let image = TransferFunction2d::Image(image);
    assert!(written(&image).starts_with("[image]\nwidth = 1\n"), "{}", written(&image));
    assert_eq!(read(&written(&image)), Ok(image));
    let transfer = TransferFunction::new([(1.0, 0.5)], [(0.0, [1.0; 3])]).unwrap();
    let style = LabelStyle { transfer: Some(transfer), color: Some([0.1; 3]), opacity: 0.3 };
    for style in [style, LabelStyle::default()] {
        assert_eq!(read(&written(&style)), Ok(style));
    }
}

#[test]
fn serialized_curves_are_lists_of_points() {
    #[derive(Debug, PartialEq, serde::Deserialize, Serialize)]
    struct Curve<const N: usize> {
        points: PiecewiseLinear<N>,
    }
    let points = PiecewiseLinear::new("it", [(0.1, [0.5, 1.0 / 3.0]), (2.0, [1.0, 0.0])]);
    check(
        &Curve::<2> { points: points.unwrap() },
        "points = [[0.1, 0.5, 0.3333333333333333], [2.0, 1.0, 0.0]]\n",
    );
    let curve = |text: &str| read::<Curve<2>>(text).unwrap_err();
    assert_eq!(curve("points = [[1, 2]]"), "point 0 of the function has 2 numbers, and not 3");
    assert_eq!(curve("points = [[]]"), "point 0 of the function has 0 numbers, and not 3");
    assert!(curve("points = [[0, 0, 2]]").contains("outside 0 to 1"));
}

#[test]
fn serialized_directions_are_the_same_bits() {
    for n in 1..200 {
        let direction = [f64::from(n).sin(), f64::from(n).cos(), 0.1 * f64::from(n % 7)];
        let light = Light::towards(direction).unwrap();
        assert_eq!(read(&written(&light)), Ok(light));
        let region = Region::new(vec![Plane::new(direction, 0.7).unwrap()]);
        assert_eq!(read(&written(&region)), Ok(region));
    }
}

#[test]
fn serialized_angles_are_in_degrees() {
    let projection = Projection::Perspective { fov_y_radians: 30_f64.to_radians() };
    let camera = Camera::new([90.0, 0.0, 0.5], [1.0; 3], [0.0, 0.0, 1.0], projection).unwrap();
    let text = written(&camera);
    assert!(text.ends_with("fov_y = 30.0\n"), "{text}");
    // Angles of which some are no number of degrees.
    for n in 0..100 {
        let projection = Projection::Perspective { fov_y_radians: 0.7 + 1e-3 * f64::from(n) };
        let camera = Camera::new([9.0, 0.0, 0.5], [1.0; 3], [0.0, 0.0, 1.0], projection).unwrap();
        assert_eq!(read(&written(&camera)), Ok(camera));
    }
}

#[test]
fn serialized_parts_may_be_left_out() {
    assert_eq!(read("width = 64"), Ok(ImageDesc { width: 64, ..ImageDesc::default() }));
    assert_eq!(read("from = \"headlight\""), Ok(Light::default()));
    assert_eq!(read("slab_width = 0.5"), Ok(RenderSettings::default().slab_width(0.5)));
    assert_eq!(read("diffuse = 0.5"), Ok(Shading::Phong(Phong::default().diffuse(0.5))));
    assert_eq!(read(""), Ok(Region::default()));
    assert_eq!(read("value = 3.0"), Ok(Isosurface::new(3.0, 1.0, None).unwrap()));
    let white = TransferFunction::new([(1.0, 0.5)], [(0.0, [1.0; 3])]).unwrap();
    assert_eq!(read("opacity = [[1.0, 0.5]]"), Ok(white));
}

#[test]
fn serialized_nonsense_is_an_error() {
    let check = |error: Result<(), String>, expected: &str| {
        let error = error.unwrap_err();
        assert!(error.contains(expected), "{error}");
    };
    let settings = |text: &str| read::<RenderSettings>(text).map(|_| ());
    check(settings("slab_width = -1.0"), "slab_width must be above 0");
    check(settings("slabwidth = 1.0"), "unknown field `slabwidth`, expected one of `method`");
    check(settings("backend = \"cpu\""), "unknown field `backend`");
    check(settings("method = \"guess\""), "\"guess\" is not a choice here");
    check(read::<Shading>("model = \"toon\"").map(|_| ()), "use one of phong, none");
    check(read::<Light>("from = \"sun\"").map(|_| ()), "\"sun\" is no light");
    check(read::<Light>("from = [0.0, 0.0, 0.0]").map(|_| ()), "the light's direction");
    check(read::<ImageDesc>("gamma = 1.0").map(|_| ()), "unknown field `gamma`");
    check(read::<Region>("planes = [[0.0, 0.0, 0.0, 1.0]]").map(|_| ()), "a plane needs");
    check(read::<TransferFunction>("opacity = []").map(|_| ()), "at least one point");
    let view = "eye = [9, 0, 0]\ntarget = [0, 0, 0]\nup = [0, 0, 1]\n";
    let camera = |more: &str| read::<Camera>(&format!("{view}{more}")).map(|_| ());
    check(camera("projection = \"perspective\"\nview_height = 1.0"), "has fov_y");
    check(camera("projection = \"perspective\"\nfov_y = 1.0\nfov_y_radians = 1.0"), "once");
    check(camera("projection = \"orthographic\""), "has view_height");
    check(camera("projection = \"orthographic\"\nview_height = -1.0"), "view_height");
    check(camera("projection = \"fisheye\"\nview_height = 1.0"), "orthographic, perspective");
}
