//! What a driver's compiler makes of the shaders: registers, instructions, the machine's own code. That
//! needs no GPU where a driver compiles without one, as Mesa's for AMD does.

use crate::choose::candidates;
use crate::context::Context;
use crate::error::Fault;
use crate::instance::Instance;
use crate::pipelines::Pipelines;
use ash::khr::pipeline_executable_properties;
use ash::vk;
use slabsplat_gpu::Unavailable;
use slabsplat_shaders::Shader;
use std::ffi::c_char;
use std::sync::Arc;

/// A shader as a driver compiled it.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct CompiledShader {
    /// The shader's name.
    pub name: &'static str,
    /// What the driver counts, by the driver's names.
    pub statistics: Vec<(String, u64)>,
    /// The shader in each language that it went through, by the driver's names, the machine's last.
    pub texts: Vec<(String, String)>,
}

/// Compiles shaders for the best device, and runs nothing. Says which device that is.
///
/// # Errors
/// If there is no device, or its driver does not tell or does not compile.
pub fn compiled(shaders: &[&'static Shader]) -> Result<(String, Vec<CompiledShader>), Unavailable> {
    let instance = Instance::new(None)?;
    let best = candidates(&instance)?.swap_remove(0);
    let device = format!("{}, {}", best.info.name, best.info.driver);
    let context = Arc::new(Context::telling(instance, best)?);
    let compiled = Telling::new(&context).compile(shaders).map_err(|fault| {
        let reason = match fault {
            Fault::OutOfMemory => "there is no memory".to_owned(),
            Fault::Driver(reason) => reason,
        };
        Unavailable { reason: format!("{device}: {reason}") }
    })?;
    Ok((device, compiled))
}

/// A device whose driver tells what it compiled.
struct Telling {
    context: Arc<Context>,
    functions: pipeline_executable_properties::Device,
}

impl Telling {
    fn new(context: &Arc<Context>) -> Self {
        let functions = pipeline_executable_properties::Device::new(
            &context.instance.functions,
            &context.functions,
        );
        Self { context: Arc::clone(context), functions }
    }

    fn compile(&self, shaders: &[&'static Shader]) -> Result<Vec<CompiledShader>, Fault> {
        let mut pipelines = Pipelines::new(&self.context)?;
        let compile = |shader: &&'static Shader| {
            let pipeline = pipelines.get(shader)?;
            // A compute pipeline has one executable.
            let of_first = vk::PipelineExecutableInfoKHR::default().pipeline(pipeline.handle);
            Ok(CompiledShader {
                name: shader.name,
                statistics: self.statistics(&of_first)?,
                texts: self.texts(&of_first)?,
            })
        };
        shaders.iter().map(compile).collect()
    }

    fn statistics(
        &self,
        executable: &vk::PipelineExecutableInfoKHR<'_>,
    ) -> Result<Vec<(String, u64)>, Fault> {
        // SAFETY: the pipeline is alive, was made to tell, and has an executable of number 0.
        let told = unsafe { self.functions.get_pipeline_executable_statistics(executable) };
        let told = told.map_err(|error| Fault::Driver(format!("its statistics: {error}")))?;
        let count = |one: &vk::PipelineExecutableStatisticKHR<'_>| {
            if one.format != vk::PipelineExecutableStatisticFormatKHR::UINT64 {
                return None;
            }
            // SAFETY: the format says that it is a number of 64 bits.
            Some((text_of(&one.name), unsafe { one.value.u64 }))
        };
        Ok(told.iter().filter_map(count).collect())
    }

    fn texts(
        &self,
        executable: &vk::PipelineExecutableInfoKHR<'_>,
    ) -> Result<Vec<(String, String)>, Fault> {
        // SAFETY: as above.
        let sizes =
            unsafe { self.functions.get_pipeline_executable_internal_representations(executable) };
        let sizes = sizes.map_err(|error| Fault::Driver(format!("its code: {error}")))?;
        let mut bytes: Vec<Vec<u8>> = sizes.iter().map(|one| vec![0; one.data_size]).collect();
        let representation =
            |bytes: &mut Vec<u8>| vk::PipelineExecutableInternalRepresentationKHR {
                data_size: bytes.len(),
                p_data: bytes.as_mut_ptr().cast(),
                ..Default::default()
            };
        let mut filled: Vec<_> = bytes.iter_mut().map(representation).collect();
        let mut n_filled = filled.len() as u32;
        let fill = self.functions.fp().get_pipeline_executable_internal_representations_khr;
        let device = self.functions.device();
        // SAFETY: as above; there are as many structs as the number says, and each points at as many bytes as
        // it says, which are there until after the call.
        unsafe { fill(device, executable, &raw mut n_filled, filled.as_mut_ptr()) }
            .result()
            .map_err(|error| Fault::Driver(format!("its code: {error}")))?;
        let names: Vec<String> = filled.iter().map(|one| text_of(&one.name)).collect();
        let text =
            |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).trim_end_matches('\0').to_owned();
        Ok(names.into_iter().zip(bytes.into_iter().map(text)).collect())
    }
}

fn text_of(text: &[c_char]) -> String {
    let bytes: Vec<u8> = text.iter().map(|&c| c.cast_unsigned()).take_while(|&c| c != 0).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}
