//! Pictures of the page for the documentation: `PSCHEMA_SCREENSHOTS=DIR cargo test --release -p pschema-tools --test view screenshots`.

use crate::browser::Browser;
use crate::house::House;

#[test]
fn screenshots() {
    let Some(folder) = std::env::var_os("PSCHEMA_SCREENSHOTS").map(std::path::PathBuf::from) else {
        println!("skipped: PSCHEMA_SCREENSHOTS names no folder for them");
        return;
    };
    let mut browser = Browser::launch().expect("a browser");
    let house = House::new();
    let life = house.path("life");
    let daemon = ["server", "--seed", "7", "--curriculum", "exp1-s1", "--data", life.to_str().unwrap()];
    let _daemon = house.start(&daemon);
    house.until(|_| true);
    let (_view, at) = house.view(&[]);
    browser.look(1280, 1480, false);
    browser.go(&at.url);
    browser.until("document.getElementById('name').textContent === 'default'");
    // Somewhere where it has learnt to touch, and there is something to see.
    let _body = house.start(&["sim", "--seed", "7"]);
    house.until(|status| {
        let text = status["world"].to_string();
        status["step"].as_u64() > Some(300) && text.contains("touch{}")
    });
    house.json(&["stage", "hold"]);
    browser.until("document.getElementById('state').textContent.includes('held')");
    browser.until("document.querySelectorAll('#trace circle.touched').length > 0");
    browser.until("Number(document.documentElement.dataset.frames) > 3");
    // To where it touches something.
    let touches = "document.getElementById('world').textContent.includes('touch{}')";
    for _ in 0..20 {
        if browser.eval(touches) == true {
            break;
        }
        let step = browser.eval("document.getElementById('state').dataset.step");
        browser.eval("document.getElementById('step').click()");
        browser.until(&format!("document.getElementById('state').dataset.step !== {step}"));
    }
    assert_eq!(browser.eval(touches), true, "it learnt to touch");
    let shown = browser.eval("document.documentElement.dataset.frames");
    browser.until(&format!("Number(document.documentElement.dataset.frames) > Number({shown}) + 3"));
    browser.eval("document.getElementById('numbers').click()");
    browser.until("document.querySelectorAll('#list tr').length > 5");
    browser.eval("document.querySelector('#candidates details').open = true");
    for (name, width, height, dark) in
        [("view", 1280, 1480, false), ("view-dark", 1280, 1480, true), ("view-400", 400, 1480, false)]
    {
        browser.look(width, height, dark);
        browser.until(
            "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))",
        );
        std::fs::write(folder.join(format!("{name}.png")), browser.picture(false)).unwrap();
    }
    browser.look(1280, 900, false);
    browser.eval("document.querySelector('#filter [name=generalised]').click()");
    browser.until("document.querySelectorAll('#list tr').length > 0 && document.querySelector('#list td:nth-child(2)').textContent === 'generalised'");
    browser.eval("document.querySelector('#list button').click()");
    browser.until("!document.getElementById('one').hidden");
    browser.eval("document.querySelector('#draw [name=around]').value = document.querySelector('#list button').textContent");
    browser.eval("document.querySelector('#draw button').click()");
    browser.until("document.getElementById('drawing').shadowRoot.querySelectorAll('g.node').length > 1");
    browser.eval("document.getElementById('one').scrollIntoView({block: 'start'})");
    browser
        .until("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))");
    std::fs::write(folder.join("view-schema.png"), browser.picture(false)).unwrap();
}
