//! Prints what a driver's compiler makes of every shader, as `cargo xtask bench shaders` reads it: a line
//! `shader NAME`, lines `count NUMBER NAME` of what the driver counts, and the machine's own code, each
//! line after `code`. With the name of a shader it prints that one alone.

use slabsplat_shaders::ALL;

fn main() {
    let wanted = std::env::args().nth(1);
    let is_wanted = |name: &str| wanted.as_ref().is_none_or(|wanted| wanted == name);
    let shaders: Vec<_> = ALL.iter().copied().filter(|shader| is_wanted(shader.name)).collect();
    let (device, compiled) = match slabsplat_ash::compiled(&shaders) {
        Ok(compiled) => compiled,
        Err(unavailable) => {
            eprintln!("error: {unavailable}");
            std::process::exit(1);
        }
    };
    println!("device {device}");
    for shader in compiled {
        println!("shader {}", shader.name);
        for (name, count) in &shader.statistics {
            println!("count {count} {name}");
        }
        let code = shader.texts.last().map_or("", |(_, text)| text);
        code.lines().for_each(|line| println!("code {line}"));
    }
}
