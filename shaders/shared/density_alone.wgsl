// Densities of a layer that is alone in its picture, without meshes: its last six sheets stay in registers.

const MOST_LAYERS: u32 = 1u;

fn n_layers() -> u32 {
    return 1u;
}

fn staged_layer(i: u32) -> u32 {
    return 0u;
}

fn begin_sheet() {
}

fn push_sheet(layer: u32, sheet: vec4<f32>) {
    for (var i = 0u; i + 1u < N_SHEETS; i++) {
        sheets[i] = sheets[i + 1u];
    }
    sheets[N_SHEETS - 1u] = sheet;
}

fn begin_rays(tile: u32, pixel: u32, todo: TileWork) {
}
