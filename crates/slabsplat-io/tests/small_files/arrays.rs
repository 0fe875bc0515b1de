//! Small valid files of the formats that hold arrays: 4 × 3 × 2 voxels of 16 bits.

/// An array of NumPy.
pub(crate) fn npy(data: &[u8]) -> Vec<u8> {
    let text = "{'descr': '<i2', 'fortran_order': True, 'shape': (2, 3, 4), }";
    let text = format!("{text:<117}\n");
    [&b"\x93NUMPY\x01\x00\x76\x00"[..], text.as_bytes(), data].concat()
}

/// An archive of files as they are.
pub(crate) fn zip(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = Vec::new();
    let mut directory = Vec::new();
    for (name, bytes) in files {
        let mut crc = flate2::Crc::new();
        crc.update(bytes);
        let n_bytes = (bytes.len() as u32).to_le_bytes();
        let n_name = (name.len() as u16).to_le_bytes();
        let sum = crc.sum().to_le_bytes();
        let fields =
            [&[20, 0, 0, 0, 0, 0, 0, 0, 0, 0][..], &sum, &n_bytes, &n_bytes, &n_name, &[0, 0]];
        let fields = fields.concat();
        let header_at = (archive.len() as u32).to_le_bytes();
        archive.extend([&b"PK\x03\x04"[..], &fields, name.as_bytes(), bytes].concat());
        let entry = [&b"PK\x01\x02\x14\x00"[..], &fields, &[0; 10], &header_at, name.as_bytes()];
        directory.extend(entry.concat());
    }
    let n_files = (files.len() as u16).to_le_bytes();
    let n_directory = (directory.len() as u32).to_le_bytes();
    let at = (archive.len() as u32).to_le_bytes();
    let end = [&b"PK\x05\x06\0\0\0\0"[..], &n_files, &n_files, &n_directory, &at, &[0, 0]].concat();
    [archive, directory, end].concat()
}

fn vti(file: &str, array: &str, data: &[u8]) -> Vec<u8> {
    let text = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" {file}>\n<ImageData \
         WholeExtent=\"0 3 0 2 0 1\" Origin=\"1 2 3\" Spacing=\"1 1 2\" Direction=\"1 0 0 0 1 0 0 0 1\">\n\
         <Piece Extent=\"0 3 0 2 0 1\">\n<PointData Scalars=\"a\">\n<DataArray type=\"Int16\" Name=\"a\" \
         {array}</DataArray>\n</PointData>\n</Piece>\n</ImageData>\n"
    );
    [text.as_bytes(), data].concat()
}

/// An image of VTK with one block, packed by zlib, at its end.
pub(crate) fn vti_raw(packed: &[u8]) -> Vec<u8> {
    let words = [1, 48, 0, packed.len() as u32].map(u32::to_le_bytes).concat();
    let data =
        [b"<AppendedData encoding=\"raw\">\n_", &words[..], packed, b"\n</AppendedData>"].concat();
    let file =
        "byte_order=\"LittleEndian\" header_type=\"UInt32\" compressor=\"vtkZLibDataCompressor\"";
    vti(file, "format=\"appended\" offset=\"0\">", &data)
}

/// An image of VTK in text.
pub(crate) fn vti_text(text: &str) -> Vec<u8> {
    vti("", &format!("format=\"ascii\">\n{text}\n"), b"</VTKFile>\n")
}

/// An image in VTK's legacy format.
pub(crate) fn vtk(kind: &str, data: &[u8]) -> Vec<u8> {
    let text = format!(
        "# vtk DataFile Version 3.0\na title\n{kind}\nDATASET STRUCTURED_POINTS\nDIMENSIONS 4 3 2\n\
         SPACING 1 1 2\nORIGIN 1 2 3\nPOINT_DATA 24\nSCALARS a short 1\nLOOKUP_TABLE default\n"
    );
    [text.as_bytes(), data, b"\n"].concat()
}

const IMAGE: &str = r#""multiscales": [{"axes": [{"name": "z", "type": "space", "unit": "micrometer"},
    {"name": "y", "type": "space", "unit": "micrometer"}, {"name": "x", "type": "space", "unit": "micrometer"}],
    "datasets": [{"path": "0", "coordinateTransformations": [{"type": "scale", "scale": [2, 1, 1]}]}]}]"#;

/// OME-Zarr 0.4 of one chunk, in an archive.
pub(crate) fn zarr_2(packed: &[u8]) -> Vec<u8> {
    let array = r#"{"zarr_format": 2, "shape": [2, 3, 4], "chunks": [2, 3, 4], "dtype": "<i2", "order": "C",
        "compressor": {"id": "gzip"}, "fill_value": 0, "filters": null}"#;
    let attributes = format!("{{{IMAGE}}}");
    zip(&[(".zattrs", attributes.as_bytes()), ("0/.zarray", array.as_bytes()), ("0/0.0.0", packed)])
}

/// OME-Zarr 0.5 of one shard of two chunks, in an archive.
pub(crate) fn zarr_3(data: &[u8]) -> Vec<u8> {
    let array = r#"{"zarr_format": 3, "node_type": "array", "shape": [2, 3, 4], "data_type": "int16",
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [2, 3, 4]}},
        "chunk_key_encoding": {"name": "default"}, "fill_value": 0, "codecs": [{"name": "sharding_indexed",
        "configuration": {"chunk_shape": [1, 3, 4], "codecs": [{"name": "bytes"}],
        "index_codecs": [{"name": "bytes"}]}}]}"#;
    let group = format!(
        r#"{{"zarr_format": 3, "node_type": "group", "attributes": {{"ome": {{{IMAGE}}}}}}}"#
    );
    let index = [0_u64, 24, 24, 24].map(u64::to_le_bytes).concat();
    zip(&[
        ("zarr.json", group.as_bytes()),
        ("0/zarr.json", array.as_bytes()),
        ("0/c/0/0/0", &[data, &index].concat()),
    ])
}
