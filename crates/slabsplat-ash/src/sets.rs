//! Descriptor sets: which slices of buffers a shader is bound to. They are cached, for most passes see the
//! same in every frame.

use crate::context::Context;
use crate::error::{Fault, during};
use crate::memory::Buffer;
use crate::pipelines::{Pipeline, ShaderId, descriptor_type};
use ash::vk;
use slabsplat_gpu::{BufferId, Pass, Slice};
use slabsplat_shaders::{BindingKind, Shader};
use std::collections::HashMap;
use std::sync::Arc;

/// Sets that a pool of descriptors has room for.
const SETS_PER_POOL: u32 = 16;
/// Sets that are cached though no recording uses them.
const MAX_IDLE_SETS: usize = 512;

/// A descriptor set that is filled in. Whoever has an `Arc` of it may submit commands with it.
pub(crate) struct Set {
    pub(crate) handle: vk::DescriptorSet,
}

/// What a set is for.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Key {
    shader: ShaderId,
    bindings: Vec<Slice>,
}

/// All descriptor sets.
pub(crate) struct Sets {
    filled: HashMap<Key, Arc<Set>>,
    /// Sets of a shader to be filled in anew.
    spare: HashMap<ShaderId, Vec<vk::DescriptorSet>>,
    pools: Vec<vk::DescriptorPool>,
    context: Arc<Context>,
}

impl Sets {
    pub(crate) fn new(context: &Arc<Context>) -> Self {
        Self {
            filled: HashMap::new(),
            spare: HashMap::new(),
            pools: Vec::new(),
            context: Arc::clone(context),
        }
    }

    /// The set of a pass; `buffers` are those of its bindings.
    pub(crate) fn get(
        &mut self,
        pass: &Pass,
        pipeline: &Pipeline,
        buffers: &[&Buffer],
    ) -> Result<Arc<Set>, Fault> {
        let key = Key { shader: ShaderId::of(pass.shader), bindings: pass.bindings.clone() };
        if let Some(set) = self.filled.get(&key) {
            return Ok(Arc::clone(set));
        }
        let set = Arc::new(Set { handle: self.empty(pass.shader, pipeline)? });
        fill(&self.context, &set, pass, buffers);
        self.filled.insert(key, Arc::clone(&set));
        Ok(set)
    }

    /// Makes sets of a buffer free that is about to go; nobody uses them any more.
    pub(crate) fn forget(&mut self, buffer: BufferId) {
        self.make_free(|key| key.bindings.iter().any(|slice| slice.buffer == buffer));
    }

    /// Makes sets free that nobody uses, if they have become many.
    pub(crate) fn trim(&mut self) {
        let n_idle = self.filled.values().filter(|set| Arc::strong_count(set) == 1).count();
        if MAX_IDLE_SETS < n_idle {
            self.make_free(|_| true);
        }
    }

    /// How many are cached.
    #[cfg(test)]
    pub(crate) fn n_filled(&self) -> usize {
        self.filled.len()
    }

    fn make_free(&mut self, chosen: impl Fn(&Key) -> bool) {
        let is_free = |key: &Key, set: &Arc<Set>| Arc::strong_count(set) == 1 && chosen(key);
        for (key, set) in self.filled.extract_if(|key, set| is_free(key, set)) {
            self.spare.entry(key.shader).or_default().push(set.handle);
        }
    }

    /// A set that is not filled in.
    fn empty(
        &mut self,
        shader: &'static Shader,
        pipeline: &Pipeline,
    ) -> Result<vk::DescriptorSet, Fault> {
        let spare = self.spare.entry(ShaderId::of(shader)).or_default();
        if let Some(set) = spare.pop() {
            return Ok(set);
        }
        let pool = create_pool(&self.context, shader)?;
        self.pools.push(pool);
        let layouts = [pipeline.set_layout; SETS_PER_POOL as usize];
        let info =
            vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
        // SAFETY: pool and layout are of this device, and the pool has room for them all.
        let mut sets = unsafe { self.context.functions.allocate_descriptor_sets(&info) }
            .map_err(during("vkAllocateDescriptorSets"))?;
        let set = sets.pop().expect("Vulkan gives as many as it was asked for");
        spare.append(&mut sets);
        Ok(set)
    }
}

impl Drop for Sets {
    fn drop(&mut self) {
        for pool in &self.pools {
            // SAFETY: an `AshDevice` waits for the queue before it drops its parts.
            unsafe { self.context.functions.destroy_descriptor_pool(*pool, None) };
        }
    }
}

fn create_pool(context: &Context, shader: &Shader) -> Result<vk::DescriptorPool, Fault> {
    let n_bindings = shader.bindings.len() as u32;
    let is_uniform = |kind: BindingKind| kind == BindingKind::Uniform;
    let n_uniform =
        shader.bindings.iter().filter(|binding| is_uniform(binding.kind)).count() as u32;
    let room = [
        (vk::DescriptorType::UNIFORM_BUFFER, n_uniform),
        (vk::DescriptorType::STORAGE_BUFFER, n_bindings - n_uniform),
    ];
    let sizes: Vec<_> = room
        .into_iter()
        .filter(|(_, n)| 0 < *n)
        .map(|(ty, n)| vk::DescriptorPoolSize::default().ty(ty).descriptor_count(n * SETS_PER_POOL))
        .collect();
    let info = vk::DescriptorPoolCreateInfo::default().max_sets(SETS_PER_POOL).pool_sizes(&sizes);
    // SAFETY: the device is alive, and no size is 0.
    unsafe { context.functions.create_descriptor_pool(&info, None) }
        .map_err(during("vkCreateDescriptorPool"))
}

fn fill(context: &Context, set: &Set, pass: &Pass, buffers: &[&Buffer]) {
    let slices: Vec<_> = pass
        .bindings
        .iter()
        .zip(buffers)
        .map(|(slice, buffer)| {
            [vk::DescriptorBufferInfo::default()
                .buffer(buffer.handle)
                .offset(slice.offset)
                .range(slice.size)]
        })
        .collect();
    let writes: Vec<_> = (0..)
        .zip(pass.shader.bindings)
        .zip(&slices)
        .map(|((number, binding), slice)| {
            vk::WriteDescriptorSet::default()
                .dst_set(set.handle)
                .dst_binding(number)
                .descriptor_type(descriptor_type(binding))
                .buffer_info(slice)
        })
        .collect();
    // SAFETY: no commands that use the set are with the device, for it is new or was free; the slices
    // are within their buffers and aligned, see `check::pass`.
    unsafe { context.functions.update_descriptor_sets(&writes, &[]) };
}
