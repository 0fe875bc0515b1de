//! What the metadata of an array say, the same for both versions of Zarr.

use serde_json::Value;
use slabsplat_core::SampleType;

use super::super::Endian;
use super::super::stored::StoredType;

/// An array, by its axes with the slowest first.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ArrayMeta {
    pub(super) shape: Vec<usize>,
    pub(super) stored: StoredType,
    /// One item as it is in chunks that are not there.
    pub(super) fill: Vec<u8>,
    pub(super) keys: Keys,
    pub(super) chunks: Chunks,
}

/// How chunks are named.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    pub(super) prefix: &'static str,
    pub(super) separator: char,
}

/// How the items of a chunk become bytes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Chunks {
    pub(super) shape: Vec<usize>,
    /// The axes in the order of the bytes, the slowest first.
    pub(super) order: Vec<usize>,
    pub(super) endian: Endian,
    /// What packs the bytes, the first first.
    pub(super) codecs: Vec<Codec>,
    /// Chunks in each chunk.
    pub(super) shard: Option<Box<Shard>>,
}

/// What packs bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Codec {
    Gzip,
    Zlib,
    Zstd,
    Blosc,
    Crc32c,
}

/// Chunks in a chunk, with an index of where they are.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Shard {
    pub(super) chunks: Chunks,
    pub(super) index_is_at_end: bool,
    /// Whether a sum follows the index.
    pub(super) has_sum: bool,
}

/// Items of a chunk: more would be a mistake, or an attack.
const MAX_CHUNK_ITEMS: u64 = 1 << 32;

/// Axes of an array that an image may have.
const MAX_AXES: usize = 16;

impl ArrayMeta {
    /// Of `.zarray`.
    pub(super) fn of_v2(meta: &Value) -> Result<Self, String> {
        let dtype = meta["dtype"].as_str().ok_or("items of several fields are no samples")?;
        let (order, code) = dtype.split_at_checked(1).ok_or("the array has no dtype")?;
        let stored = StoredType::of_code(code)
            .ok_or_else(|| format!("items of type {} cannot be samples", shown(dtype)))?;
        let endian = if order == ">" { Endian::Big } else { Endian::Little };
        let shape = sizes(&meta["shape"], "shape")?;
        let mut order: Vec<usize> = (0..shape.len()).collect();
        if meta["order"] == "F" {
            order.reverse();
        }
        if meta["filters"].as_array().is_some_and(|filters| !filters.is_empty()) {
            let id = shown(meta["filters"][0]["id"].as_str().unwrap_or_default());
            return Err(format!("arrays with the filter {id} cannot be read: save it without"));
        }
        let codecs = match &meta["compressor"] {
            Value::Null => Vec::new(),
            compressor => vec![codec(compressor["id"].as_str().unwrap_or_default())?],
        };
        let separator = if meta["dimension_separator"] == "/" { '/' } else { '.' };
        let chunks =
            Chunks { shape: sizes(&meta["chunks"], "chunks")?, order, endian, codecs, shard: None };
        let fill = fill(&meta["fill_value"], stored, endian)?;
        Self { shape, stored, fill, keys: Keys { prefix: "", separator }, chunks }.checked()
    }

    /// Of `zarr.json`.
    pub(super) fn of_v3(meta: &Value) -> Result<Self, String> {
        let name = meta["data_type"].as_str().unwrap_or("of several fields");
        let stored = StoredType::named(if name == "bool" { "uint8" } else { name })
            .ok_or_else(|| format!("items of type {} cannot be samples", shown(name)))?;
        let shape = sizes(&meta["shape"], "shape")?;
        let grid = &meta["chunk_grid"];
        if grid["name"] != "regular" {
            return Err("chunks that are not all of one size cannot be read".to_owned());
        }
        let chunk_shape = sizes(&grid["configuration"]["chunk_shape"], "chunk_shape")?;
        let encoding = &meta["chunk_key_encoding"];
        let separator = encoding["configuration"]["separator"].as_str();
        let keys = match encoding["name"].as_str() {
            Some("default") => Keys { prefix: "c", separator: separator_of(separator, '/')? },
            Some("v2") => Keys { prefix: "", separator: separator_of(separator, '.')? },
            other => {
                return Err(format!(
                    "keys of chunks by {} are unknown",
                    shown(other.unwrap_or(""))
                ));
            }
        };
        let codecs = meta["codecs"].as_array().ok_or("the array has no codecs")?;
        let chunks = Chunks::of(codecs, chunk_shape, true)?;
        let fill = fill(&meta["fill_value"], stored, chunks.innermost().endian)?;
        Self { shape, stored, fill, keys, chunks }.checked()
    }

    fn checked(self) -> Result<Self, String> {
        let n_axes = self.shape.len();
        if MAX_AXES < n_axes || self.shape.contains(&0) {
            return Err(format!("an array of the shape {:?} is no image", self.shape));
        }
        let shard = self.chunks.shard.as_ref();
        let inner = shard.map_or(&self.chunks, |shard| &shard.chunks);
        for chunks in [&self.chunks, inner] {
            let n_items = chunks.shape.iter().try_fold(1_usize, |n, len| n.checked_mul(*len));
            let is_sane = n_items.is_some_and(|n| 0 < n && n as u64 <= MAX_CHUNK_ITEMS);
            if chunks.shape.len() != n_axes || !is_sane {
                return Err(format!("chunks cannot have the shape {:?}", chunks.shape));
            }
        }
        let is_multiple = |(outer, inner): (&usize, &usize)| outer.is_multiple_of(*inner);
        if !self.chunks.shape.iter().zip(&inner.shape).all(is_multiple) {
            return Err("a shard is not made of whole chunks".to_owned());
        }
        Ok(self)
    }
}

impl Chunks {
    fn of(list: &[Value], shape: Vec<usize>, may_be_shard: bool) -> Result<Self, String> {
        let order = (0..shape.len()).collect();
        let (endian, codecs) = (Endian::Little, Vec::new());
        let mut chunks = Self { shape, order, endian, codecs, shard: None };
        for item in list {
            let config = &item["configuration"];
            let name = item["name"].as_str().or(item.as_str()).unwrap_or_default();
            match name {
                "bytes" => chunks.endian = endian_of(config),
                "transpose" => {
                    let order = sizes_or_zero(&config["order"]);
                    let mut sorted = order.clone();
                    sorted.sort_unstable();
                    if !sorted.iter().copied().eq(0..chunks.shape.len()) {
                        return Err("the axes cannot be transposed in that order".to_owned());
                    }
                    // One after the other.
                    chunks.order = order.iter().map(|&axis| chunks.order[axis]).collect();
                }
                "sharding_indexed" if may_be_shard && chunks.shard.is_none() => {
                    chunks.shard = Some(Box::new(Shard::of(config)?));
                }
                other => chunks.codecs.push(codec(other)?),
            }
        }
        if chunks.shard.is_some() && !chunks.codecs.is_empty() {
            return Err("shards that are packed as a whole cannot be read".to_owned());
        }
        Ok(chunks)
    }

    /// Those whose bytes are items.
    pub(super) fn innermost(&self) -> &Self {
        self.shard.as_ref().map_or(self, |shard| &shard.chunks)
    }
}

impl Shard {
    fn of(config: &Value) -> Result<Self, String> {
        let codecs = config["codecs"].as_array().ok_or("a shard has no codecs")?;
        let chunks = Chunks::of(codecs, sizes(&config["chunk_shape"], "chunk_shape")?, false)?;
        let index =
            config["index_codecs"].as_array().ok_or("a shard has no codecs of its index")?;
        let mut has_sum = false;
        for item in index {
            match item["name"].as_str() {
                Some("bytes") if endian_of(&item["configuration"]) == Endian::Little => {}
                Some("crc32c") => has_sum = true,
                other => {
                    let other = shown(other.unwrap_or_default());
                    return Err(format!("the index of a shard by {other} cannot be read"));
                }
            }
        }
        let index_is_at_end = config["index_location"] != "start";
        Ok(Self { chunks, index_is_at_end, has_sum })
    }
}

fn codec(name: &str) -> Result<Codec, String> {
    match name {
        "gzip" => Ok(Codec::Gzip),
        "zlib" | "numcodecs.zlib" => Ok(Codec::Zlib),
        "zstd" | "numcodecs.zstd" => Ok(Codec::Zstd),
        "blosc" | "numcodecs.blosc" => Ok(Codec::Blosc),
        "crc32c" => Ok(Codec::Crc32c),
        other => Err(format!(
            "chunks packed by {} cannot be read: save them with gzip, zstd or blosc",
            shown(other)
        )),
    }
}

fn endian_of(config: &Value) -> Endian {
    if config["endian"] == "big" { Endian::Big } else { Endian::Little }
}

fn separator_of(text: Option<&str>, default: char) -> Result<char, String> {
    match text {
        None => Ok(default),
        Some("/") => Ok('/'),
        Some(".") => Ok('.'),
        Some(other) => Err(format!("keys of chunks cannot be separated by {}", shown(other))),
    }
}

fn sizes(value: &Value, name: &str) -> Result<Vec<usize>, String> {
    let list = value.as_array().ok_or_else(|| format!("the array has no {name}"))?;
    let sizes = list.iter().map(|size| size.as_u64().and_then(|n| usize::try_from(n).ok()));
    sizes.collect::<Option<_>>().ok_or_else(|| format!("the array's {name} is not a list of sizes"))
}

fn sizes_or_zero(value: &Value) -> Vec<usize> {
    let list = value.as_array().map(Vec::as_slice).unwrap_or_default();
    list.iter().map(|size| size.as_u64().map_or(usize::MAX, |n| n as usize)).collect()
}

/// The bytes of an item of that value.
fn fill(value: &Value, stored: StoredType, endian: Endian) -> Result<Vec<u8>, String> {
    let number = match value {
        Value::Null => 0.0,
        Value::Bool(is_true) => f64::from(u8::from(*is_true)),
        Value::Number(number) => number.as_f64().unwrap_or(f64::NAN),
        Value::String(text) => match text.as_str() {
            "NaN" => f64::NAN,
            "Infinity" => f64::INFINITY,
            "-Infinity" => f64::NEG_INFINITY,
            other => return Err(format!("a fill value of {} cannot be read", shown(other))),
        },
        _ => return Err("the fill value is no number".to_owned()),
    };
    let mut bytes = match stored {
        StoredType::Sample(SampleType::U8) => (number as u8).to_le_bytes().to_vec(),
        StoredType::Sample(SampleType::I8) => (number as i8).to_le_bytes().to_vec(),
        StoredType::Sample(SampleType::U16) => (number as u16).to_le_bytes().to_vec(),
        StoredType::Sample(SampleType::I16) => (number as i16).to_le_bytes().to_vec(),
        StoredType::Sample(SampleType::U32) => (number as u32).to_le_bytes().to_vec(),
        StoredType::Sample(SampleType::I32) => (number as i32).to_le_bytes().to_vec(),
        StoredType::Sample(SampleType::F32) => (number as f32).to_le_bytes().to_vec(),
        StoredType::Sample(SampleType::F64) => number.to_le_bytes().to_vec(),
        StoredType::F16 => half::f16::from_f64(number).to_le_bytes().to_vec(),
        StoredType::I64 => value.as_i64().unwrap_or(number as i64).to_le_bytes().to_vec(),
        StoredType::U64 => value.as_u64().unwrap_or(number as u64).to_le_bytes().to_vec(),
    };
    if endian == Endian::Big {
        bytes.reverse();
    }
    Ok(bytes)
}

/// A word of a file in a message.
pub(super) fn shown(text: &str) -> String {
    let text: String = text.chars().take(40).collect();
    format!("{text:?}")
}
