//! Work-around for Mesa's software Vulkan driver: uniforms become private copies of storage buffers.

use naga::{
    AddressSpace, Arena, Block, Expression, GlobalVariable, Handle, Module, Range, Span, Statement,
    StorageAccess,
};

/// Turns every uniform into a read-only storage buffer of the same layout that the entry point copies into a private
/// variable first.
///
/// Lavapipe (seen in 22.3) inlines uniform loads into shaders and overruns a fixed array while it does so, which
/// corrupts its stack and heap; it also recompiles whenever a value changes. It does not inline storage buffers, but
/// reads them lane by lane at every use: hence the copy. Other drivers get the shaders unchanged.
pub(super) fn uniforms_as_private_copies(module: &mut Module) {
    let uniforms: Vec<_> = module
        .global_variables
        .iter()
        .filter(|(_, variable)| variable.space == AddressSpace::Uniform)
        .map(|(handle, _)| handle)
        .collect();
    for buffer in uniforms {
        let variable = module.global_variables.get_mut(buffer);
        variable.space = AddressSpace::Storage {
            access: StorageAccess::LOAD,
        };
        let private = GlobalVariable {
            name: variable.name.as_ref().map(|name| format!("{name}_copy")),
            space: AddressSpace::Private,
            binding: None,
            ..variable.clone()
        };
        let copy = module.global_variables.append(private, Span::UNDEFINED);
        if redirect(module, buffer, copy) {
            for entry in &mut module.entry_points {
                let function = &mut entry.function;
                copy_first(&mut function.expressions, &mut function.body, buffer, copy);
            }
        }
    }
}

/// Makes every use of `from` one of `to`; tells whether there was any.
fn redirect(module: &mut Module, from: Handle<GlobalVariable>, to: Handle<GlobalVariable>) -> bool {
    let functions = module.functions.iter_mut().map(|(_, function)| function);
    let entries = module.entry_points.iter_mut().map(|e| &mut e.function);
    let mut found = false;
    for function in functions.chain(entries) {
        for (_, expression) in function.expressions.iter_mut() {
            if *expression == Expression::GlobalVariable(from) {
                *expression = Expression::GlobalVariable(to);
                found = true;
            }
        }
    }
    found
}

/// Puts `to = from` before everything else.
fn copy_first(
    expressions: &mut Arena<Expression>,
    body: &mut Block,
    from: Handle<GlobalVariable>,
    to: Handle<GlobalVariable>,
) {
    let mut append = |expression| expressions.append(expression, Span::UNDEFINED);
    let (source, pointer) = (
        append(Expression::GlobalVariable(from)),
        append(Expression::GlobalVariable(to)),
    );
    let value = append(Expression::Load { pointer: source });
    let copy = [
        Statement::Emit(Range::new_from_bounds(value, value)),
        Statement::Store { pointer, value },
    ];
    let rest = std::mem::replace(body, Block::from_vec(copy.into()));
    body.extend_block(rest);
}
