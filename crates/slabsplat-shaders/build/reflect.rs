//! What a host must know of a stage: its bindings, its workgroups, the layout of its structs.

use crate::assemble::Stage;
use anyhow::{Context, Result, bail, ensure};
use naga::{AddressSpace, Module, StorageAccess, TypeInner};

/// A stage with everything that is known of it.
pub(crate) struct Reflected {
    pub(crate) name: String,
    pub(crate) wgsl: String,
    pub(crate) spirv: Vec<u32>,
    pub(crate) workgroup_size: [u32; 3],
    /// In the order of their numbers, which have no gaps.
    pub(crate) bindings: Vec<Binding>,
    pub(crate) structs: Vec<Struct>,
}

pub(crate) struct Binding {
    pub(crate) name: String,
    pub(crate) kind: &'static str,
}

#[derive(PartialEq)]
pub(crate) struct Struct {
    pub(crate) name: String,
    pub(crate) size: u32,
    /// Name, offset and size.
    pub(crate) members: Vec<(String, u32, u32)>,
}

pub(crate) fn reflect(stage: &Stage, module: &Module, spirv: Vec<u32>) -> Result<Reflected> {
    let [entry_point] = module.entry_points.as_slice() else {
        bail!("a stage has one entry point");
    };
    ensure!(entry_point.name == stage.name, "the entry point is called as the file");
    Ok(Reflected {
        name: stage.name.clone(),
        wgsl: stage.wgsl.clone(),
        spirv,
        workgroup_size: entry_point.workgroup_size,
        bindings: bindings(module)?,
        structs: structs(module),
    })
}

fn bindings(module: &Module) -> Result<Vec<Binding>> {
    let mut found = Vec::new();
    for (_, variable) in module.global_variables.iter() {
        let Some(at) = variable.binding else { continue };
        ensure!(at.group == 0, "all bindings are in group 0");
        let kind = match variable.space {
            AddressSpace::Uniform => "Uniform",
            AddressSpace::Storage { access } if access.contains(StorageAccess::STORE) => "Written",
            AddressSpace::Storage { .. } => "Read",
            other => bail!("no binding lives in {other:?}"),
        };
        let name = variable.name.clone().context("bindings have names")?;
        found.push((at.binding, Binding { name, kind }));
    }
    found.sort_by_key(|(number, _)| *number);
    let is_dense = found.iter().enumerate().all(|(idx, (number, _))| idx == *number as usize);
    ensure!(is_dense, "bindings are numbered from 0 without gaps");
    Ok(found.into_iter().map(|(_, binding)| binding).collect())
}

fn structs(module: &Module) -> Vec<Struct> {
    let named = module.types.iter().filter_map(|(_, ty)| match &ty.inner {
        TypeInner::Struct { members, span } => Some((ty.name.clone()?, members, *span)),
        _ => None,
    });
    named
        .map(|(name, members, size)| {
            let member = |member: &naga::StructMember| {
                let inner = &module.types[member.ty].inner;
                let name = member.name.clone().unwrap_or_default();
                (name, member.offset, inner.size(module.to_ctx()))
            };
            Struct { name, size, members: members.iter().map(member).collect() }
        })
        .collect()
}
