//! How long a start takes with memories of some sizes: `cargo run --release -p pschema-store --example restart -- DIR 20000
//! 1000000`. The directories `DIR/<schemas>` are made, and left there.

use std::path::PathBuf;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let directory = PathBuf::from(arguments.next().ok_or("name a directory, then numbers of schemas")?);
    for schemas in arguments {
        let schemas: usize = schemas.parse()?;
        let into = directory.join(schemas.to_string());
        let figures = pschema_store::bench::figures(&into, schemas)?;
        println!("{figures:#?}");
    }
    Ok(())
}
