//! What the backend refuses, before it asks anything of its device.

use super::*;
use crate::{BufferId, DeviceError, DeviceInfo};
use slabsplat_backend::Planner;
use slabsplat_core::glam::DVec3;
use slabsplat_core::{
    Camera, Grid, ImageDesc, Layer, Method, Projection, RenderSettings, Scaling, Scene,
    TransferFunction, Volume,
};
use std::sync::Arc;
use std::time::Duration;

/// A device that must not be used.
struct Untouched(DeviceInfo);

impl Device for Untouched {
    fn info(&self) -> &DeviceInfo {
        &self.0
    }

    fn create_buffer(&mut self, label: &'static str, _: u64) -> Result<BufferId, DeviceError> {
        panic!("{label} was created")
    }

    fn destroy_buffer(&mut self, _: BufferId) {}

    fn submit(&mut self, _: &Work<'_>) -> Result<WorkId, DeviceError> {
        panic!("work was submitted")
    }

    fn poll(&mut self, _: WorkId) -> Result<Poll<Done>, DeviceError> {
        panic!("there is no work")
    }

    fn wait(&mut self, _: WorkId, _: Duration) {
        panic!("there is no work")
    }
}

fn untouched() -> Untouched {
    Untouched(DeviceInfo {
        name: "Fake 3000".to_owned(),
        driver: String::new(),
        kind: DeviceKind::Other,
        max_binding_bytes: 1 << 27,
        max_buffer_bytes: 1 << 28,
        offset_alignment: 256,
        memory_bytes: None,
        has_timestamps: false,
    })
}

#[test]
fn what_shaders_lack_is_refused() {
    let grid = Grid::with_spacing([2; 3], [1.0; 3]).unwrap();
    let volume = Arc::new(Volume::new(grid, vec![1_u8; 8].into(), Scaling::IDENTITY).unwrap());
    let projection = Projection::Orthographic { view_height: 4.0 };
    let transfer = TransferFunction::new(vec![(0.0, [0.5])], vec![(0.0, [1.0; 3])]).unwrap();
    let layer = Layer::new(volume, transfer);
    let camera = Camera::new(DVec3::Z * 9.0, DVec3::ZERO, DVec3::Y, projection).unwrap();
    let image = ImageDesc::new(4, 4);
    let scene = Scene::new(layer.clone(), camera).image(image);
    let refused = |scene: &Scene| {
        let plan = Planner::default().plan(scene).unwrap();
        let (mut backend, frame) = (GpuBackend::new("fake", untouched()), FrameHandle::new());
        backend.submit(&plan, &frame).unwrap_err().to_string()
    };
    let densities = RenderSettings::default().method(Method::PostClassified);
    assert_eq!(
        refused(&scene.clone().settings(densities).layers(vec![layer.clone(); 17])),
        "Fake 3000 cannot make this frame: its shaders draw densities of 16 layers at a time, not of 17"
    );
    assert_eq!(
        refused(&scene.layers(vec![layer; 65])),
        "Fake 3000 cannot make this frame: its shaders draw 64 layers at a time, not 65"
    );
}
