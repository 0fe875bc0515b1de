//! The same for programs in C: `include/slabsplat_mpi.h` declares it, and has what each function asks of its
//! caller. All unsafe code that is called from C is here.

#![expect(clippy::exhaustive_structs, reason = "a caller in C fills them in")]

use super::{AnyError, Field, InSitu, SceneText, Values, VoxelBox};
use crate::{World, agree};
use slabsplat::io::PictureFormat;
use slabsplat::{Grid, Picture, glam::DAffine3};
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::slice;
use std::time::Duration;

/// A grid of voxels, and where it lies.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SlabsplatGrid {
    /// Voxels along x, y and z.
    pub dims: [u64; 3],
    /// Three columns, the steps along x, y and z in the world, and the centre of the first voxel.
    pub world_from_index: [f64; 12],
}

/// Some voxels: from `first` to `end`, which is not included.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SlabsplatBox {
    /// The first voxel along x, y and z.
    pub first: [u64; 3],
    /// One behind the last.
    pub end: [u64; 3],
}

/// An array of a simulation.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SlabsplatField {
    /// The value of the first voxel of `held`.
    pub values: *const c_void,
    /// 0 for unsigned integers of 8 bits, 1 for those of 16, 2 for floats, 3 for doubles.
    pub value_type: c_int,
    /// Its voxels: the rank's own, or more.
    pub held: SlabsplatBox,
    /// Values from one voxel to the next along x, y and z.
    pub strides: [u64; 3],
}

/// A simulation, as a rank has it.
#[derive(Debug)]
pub struct SlabsplatSimulation {
    /// Of the last call, if it failed.
    error: Option<CString>,
    parts: Option<(World, InSitu, SceneText)>,
}

/// Joins all ranks of a communicator, by its number in Fortran, as `MPI_Comm_c2f` gives. `own` is what this
/// rank has of `grid`, and `scene` the text of a scene file (`SceneText`). It never returns null, but what
/// has an error where that failed.
///
/// # Safety
/// - `grid` and `own` are null or point to what their types say.
/// - `scene` is null or a text that ends with a zero.
/// - MPI is started, and called by this thread alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slabsplat_simulation_new(
    comm: c_int,
    grid: *const SlabsplatGrid,
    own: *const SlabsplatBox,
    scene: *const c_char,
    patience_secs: f64,
) -> *mut SlabsplatSimulation {
    // SAFETY: the caller's first duty.
    let (grid, own) = unsafe { (grid.as_ref(), own.as_ref()) };
    // SAFETY: the caller's second duty; null is asked for before.
    let scene = (!scene.is_null()).then(|| unsafe { CStr::from_ptr(scene) });
    let made = guarded(|| {
        let patience = Duration::try_from_secs_f64(patience_secs)?;
        let world = World::of_communicator(comm, patience)?;
        let given = || {
            let (grid, own, scene) =
                grid.zip(own).zip(scene).map(|((g, o), s)| (g, o, s)).ok_or("a pointer is null")?;
            Ok::<_, AnyError>((grid_of(grid)?, voxels_of(own)?, SceneText::parse(scene.to_str()?)?))
        };
        let (grid, own, scene) = agree(&world, given())?;
        let in_situ = InSitu::new(&world, grid, &own)?;
        Ok((world, in_situ, scene))
    });
    let (parts, error) = match made {
        Ok(parts) => (Some(parts), None),
        Err(error) => (None, Some(error)),
    };
    Box::into_raw(Box::new(SlabsplatSimulation { error, parts }))
}

/// Draws the simulation. On rank 0 `pixels` gets red, green, blue and opacity of each, premultiplied, row by
/// row from the top; on others it is not written to. Returns 0 if all is well, on all ranks or on none.
///
/// # Safety
/// - `simulation` is what `slabsplat_simulation_new` returned, not freed yet, and used by this thread alone.
/// - `fields` points to `n_fields` fields, and each `values` to all values that its box and strides name.
/// - On rank 0 `pixels` has room for four floats for each pixel of the scene, or is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slabsplat_simulation_draw(
    simulation: *mut SlabsplatSimulation,
    fields: *const SlabsplatField,
    n_fields: u64,
    pixels: *mut f32,
) -> c_int {
    let to_memory = |picture: &Picture| {
        let image = picture.frame.image.pixels();
        if !pixels.is_null() {
            // SAFETY: the caller's third duty.
            let pixels = unsafe { slice::from_raw_parts_mut(pixels, 4 * image.len()) };
            pixels.copy_from_slice(bytemuck::cast_slice(image));
        }
        Ok(())
    };
    // SAFETY: the caller's first and second duty are those of `drawn`.
    unsafe { drawn(simulation, fields, n_fields, &to_memory) }
}

/// Draws the simulation, and has rank 0 write the picture to a file, in the format that its name says.
/// Returns 0 if all is well, on all ranks or on none.
///
/// # Safety
/// - As those of `slabsplat_simulation_draw`, but for `pixels`.
/// - `path` is null or a text that ends with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slabsplat_simulation_write(
    simulation: *mut SlabsplatSimulation,
    fields: *const SlabsplatField,
    n_fields: u64,
    path: *const c_char,
) -> c_int {
    // SAFETY: the caller's second duty; null is asked for before.
    let path = (!path.is_null()).then(|| unsafe { CStr::from_ptr(path) });
    let to_file = |picture: &Picture| {
        let path = Path::new(path.ok_or("a picture has to have a name")?.to_str()?);
        let format = PictureFormat::of_name(path).ok_or("no picture has such a name")?;
        Ok(format.write(path, &picture.frame.image, None)?)
    };
    // SAFETY: the caller's first duty.
    unsafe { drawn(simulation, fields, n_fields, &to_file) }
}

/// What the last call failed by, or null; it is there until the next one.
///
/// # Safety
/// - `simulation` is null or what `slabsplat_simulation_new` returned, and not freed yet.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slabsplat_simulation_error(
    simulation: *const SlabsplatSimulation,
) -> *const c_char {
    // SAFETY: the caller's duty.
    let error = unsafe { simulation.as_ref() }.and_then(|simulation| simulation.error.as_ref());
    error.map_or(std::ptr::null(), |error| error.as_ptr())
}

/// Leaves the ranks, before MPI is ended.
///
/// # Safety
/// - `simulation` is null or what `slabsplat_simulation_new` returned, and is not used any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slabsplat_simulation_free(simulation: *mut SlabsplatSimulation) {
    if !simulation.is_null() {
        // SAFETY: it was made by a box, and the caller has no other.
        drop(unsafe { Box::from_raw(simulation) });
    }
}

/// What is done with a picture on rank 0.
type Use<'a> = &'a dyn Fn(&Picture) -> Result<(), AnyError>;

/// # Safety
/// - `simulation` is null or what `slabsplat_simulation_new` returned, not freed yet, and used by this thread
///   alone.
/// - `fields` points to `n_fields` fields, and each `values` to all values that its box and strides name.
unsafe fn drawn(
    simulation: *mut SlabsplatSimulation,
    fields: *const SlabsplatField,
    n_fields: u64,
    use_picture: Use<'_>,
) -> c_int {
    // SAFETY: the caller's first duty.
    let Some(SlabsplatSimulation { error, parts }) = (unsafe { simulation.as_mut() }) else {
        return 1;
    };
    let Some((world, in_situ, scene)) = parts else { return 1 };
    let fields: &[SlabsplatField] = if fields.is_null() {
        &[]
    } else {
        // SAFETY: the caller's second duty.
        unsafe { slice::from_raw_parts(fields, n_fields as usize) }
    };
    let done = guarded(|| {
        // SAFETY: the caller's second duty.
        let fields = fields.iter().map(|field| unsafe { field_of(field) });
        let fields = agree(world, fields.collect::<Result<Vec<_>, _>>())?;
        let picture = in_situ.picture(world, &fields, |volumes| scene.scene(volumes))?;
        let used = picture.as_ref().map_or(Ok(()), use_picture);
        Ok(agree(world, used)?)
    });
    *error = done.err();
    c_int::from(error.is_some())
}

/// A panic goes no further than this crate, but ends no rank: the caller may have what must be saved.
fn guarded<T>(work: impl FnOnce() -> Result<T, AnyError>) -> Result<T, CString> {
    let error = match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(done)) => return Ok(done),
        Ok(Err(error)) => error.to_string(),
        Err(_) => "slabsplat failed inside: please report this".to_owned(),
    };
    Err(CString::new(error.replace('\0', " ")).unwrap_or_default())
}

fn grid_of(grid: &SlabsplatGrid) -> Result<Grid, AnyError> {
    let [x, y, z] = grid.dims;
    let dims = [usize::try_from(x)?, usize::try_from(y)?, usize::try_from(z)?];
    Ok(Grid::new(dims, DAffine3::from_cols_array(&grid.world_from_index))?)
}

fn voxels_of(of: &SlabsplatBox) -> Result<VoxelBox, AnyError> {
    let along = |axis: usize| {
        let range = usize::try_from(of.first[axis])?..usize::try_from(of.end[axis])?;
        if range.start <= range.end {
            Ok(range)
        } else {
            Err(AnyError::from("a box ends before it begins"))
        }
    };
    Ok([along(0)?, along(1)?, along(2)?])
}

/// # Safety
/// - `values` points to all values that the box and strides name, which stay as they are for `'a`.
unsafe fn field_of<'a>(field: &SlabsplatField) -> Result<Field<'a>, AnyError> {
    let held = voxels_of(&field.held)?;
    let [x, y, z] = field.strides;
    let strides = [usize::try_from(x)?, usize::try_from(y)?, usize::try_from(z)?];
    let dims = held.each_ref().map(ExactSizeIterator::len);
    let n_values = if dims.contains(&0) {
        0
    } else {
        let steps = dims.iter().zip(strides).map(|(n, stride)| (n - 1).checked_mul(stride));
        let last = steps.into_iter().try_fold(0_usize, |sum, step| sum.checked_add(step?));
        last.and_then(|last| last.checked_add(1)).ok_or("the strides are too long")?
    };
    if field.values.is_null() && 0 < n_values {
        return Err("an array is null".into());
    }
    // SAFETY: the caller's duty: that many values are what the box and strides name.
    let values = unsafe { values_of(field, n_values) }.ok_or("there is no such type of values")?;
    Ok(Field::strided(values, held, strides)?)
}

/// # Safety
/// - `values` points to as many of the type that `value_type` names, which stay as they are for `'a`.
unsafe fn values_of<'a>(field: &SlabsplatField, n: usize) -> Option<Values<'a>> {
    /// # Safety
    /// - As for `values_of`, of type `T`; null only where there are none.
    unsafe fn slice_of<'a, T>(values: *const c_void, n: usize) -> &'a [T] {
        if n == 0 {
            return &[];
        }
        // SAFETY: the caller's duty.
        unsafe { slice::from_raw_parts(values.cast(), n) }
    }
    let values = field.values;
    // SAFETY: the caller's duty, for the type that is named.
    Some(unsafe {
        match field.value_type {
            0 => Values::U8(slice_of(values, n)),
            1 => Values::U16(slice_of(values, n)),
            2 => Values::F32(slice_of(values, n)),
            3 => Values::F64(slice_of(values, n)),
            _ => return None,
        }
    })
}
