//! The page in a real browser.

use serde_json::Value;

use crate::browser::Browser;
use crate::house::House;

const STEP: &str = "Number(document.getElementById('state').dataset.step)";

/// The number that an expression comes to, once it is one above 0.
fn number(browser: &mut Browser, expression: &str) -> u64 {
    let value = browser.until(expression);
    value.as_u64().unwrap_or_else(|| panic!("{expression} is {value}"))
}

fn click(browser: &mut Browser, selector: &str) {
    browser.eval(&format!("document.querySelector({selector:?}).click()"));
}

fn text(browser: &mut Browser, selector: &str) -> String {
    browser.eval(&format!("document.querySelector({selector:?}).textContent")).as_str().unwrap().to_owned()
}

#[test]
fn a_learner_is_looked_into_while_it_learns() {
    let Some(mut browser) = Browser::launch() else { return };
    let house = House::new();
    let data = house.path("life");
    let daemon = house.serve(&data);
    let _body = house.start(&["sim", "--seed", "7"]);
    house.until(|status| status["step"].as_u64() > Some(80));
    let (_view, at) = house.view(&[]);
    browser.go(&at.url);

    // It shows the learner as it goes on.
    let first = number(&mut browser, STEP);
    browser.until(&format!("{STEP} > {first} + 5"));
    browser.until("Number(document.documentElement.dataset.frames) > 10");
    browser.until("document.getElementById('sentence').textContent.startsWith('In step ')");
    browser.until("document.querySelectorAll('#candidates li').length > 0");
    browser.until("document.querySelectorAll('#trace path.curve').length === 2");
    browser.until("document.querySelectorAll('#list tr').length === 20");

    // Small figures, and outcomes that exclude each other, read as they do on a terminal.
    let told = browser.eval(
        "import(new URL('dom.js', location.href)).then((dom) => [dom.level(0.000457), dom.level(0.5), dom.notation({ \
         pre: [], action: 'move()', post: ['finger{field=4}', 'touch{}', 'finger{field=5}'], post_shares: [0.6, 1, 0.4] \
         }), dom.notation({ pre: [], action: 'move()', post: ['ball{}', 'no longer ball{}'], post_shares: [0.7, 0.4] \
         })].join(', '))",
    );
    let expected = "0.000457, 0.500, ∅ / move() / (finger{field=4} 60 % or finger{field=5} 40 %) & touch{}, \
                    ∅ / move() / (ball{} 70 % or no longer ball{} 40 %)";
    assert_eq!(told, expected);

    // It is held, takes one step, and goes on.
    click(&mut browser, "#hold");
    browser.until("document.getElementById('state').textContent.includes('held')");
    let held = house.until(|status| status["stage_state"] == "held");
    let step = held["step"].as_u64().unwrap();
    browser.until(&format!("{STEP} === {step}"));
    click(&mut browser, "#step");
    browser.until(&format!("{STEP} > {step}"));
    house.until(|status| status["stage_state"] == "held" && status["step"].as_u64() > Some(step));

    // A schema is picked, and what it is tied to is drawn; a node of the drawing is picked.
    click(&mut browser, "#list button");
    browser.until("!document.getElementById('one').hidden");
    let picked = text(&mut browser, "#list button");
    assert_eq!(text(&mut browser, "#one-title"), format!("Schema {picked}"));
    browser.until("document.querySelectorAll('#whole .interval').length > 0");
    click(&mut browser, "#draw button");
    browser.until(
        "document.getElementById('drawing').shadowRoot.querySelectorAll('g.node[role=button]').length > 10",
    );
    let node = "document.getElementById('drawing').shadowRoot.querySelectorAll('g.node[role=button]')[3]";
    browser.eval(&format!("{node}.dispatchEvent(new MouseEvent('click', {{bubbles: true}}))"));
    browser.until(&format!(
        "'Show ' + document.getElementById('one-title').textContent.replace('Schema', 'schema') === {node}.getAttribute('aria-label')"
    ));

    // What is no word is refused, and said to be; then it hears one, and goes on.
    assert_eq!(browser.errors, Vec::<String>::new());
    browser.eval(&format!("document.getElementById('words').value = '{}'", "w".repeat(70)));
    click(&mut browser, "#say button");
    browser.until("document.getElementById('ordered').textContent.includes('is no word')");
    browser.errors.clear();
    browser.eval("document.getElementById('words').value = 'touch'");
    click(&mut browser, "#say button");
    browser.until("document.getElementById('words').value === ''");
    click(&mut browser, "#resume");
    browser.until("!document.getElementById('state').textContent.includes('held')");
    browser.until("document.querySelectorAll('#trace path.word').length > 0");
    assert_eq!(browser.errors, Vec::<String>::new());

    looked_back(&mut browser, &house);

    // The daemon ends: what is on disk can still be looked at. It is started again: the page goes on.
    daemon.end();
    browser.until("document.getElementById('banner').textContent.includes('no daemon')");
    shows(&mut browser, 30);
    click(&mut browser, "#present");
    let _daemon = house.serve(&data);
    let _body = house.start(&["sim", "--seed", "7"]);
    browser.until("document.getElementById('banner').hidden");
    let again = number(&mut browser, STEP);
    browser.until(&format!("{STEP} > {again} + 5"));
    browser.until("Number(document.getElementById('rate').textContent.split(' ')[0]) > 0");
}

/// Moves the slider, and waits for memory as it was then.
fn shows(browser: &mut Browser, step: u64) {
    browser.eval(&format!(
        "(() => {{ const slider = document.getElementById('slider'); slider.value = '{step}'; \
         slider.dispatchEvent(new Event('input')) }})()"
    ));
    browser.until(&format!(
        "document.body.dataset.shown === '{step}' && document.getElementById('when').textContent.includes('rebuilt')"
    ));
}

fn looked_back(browser: &mut Browser, house: &House) {
    let data = house.path("life");
    for step in [40_u64, 70] {
        shows(browser, step);
        let arguments = ["schemas", "--data", data.to_str().unwrap(), "--until", &step.to_string()];
        let told = house.json(&arguments).unwrap();
        let note = text(browser, "#schemas-note");
        assert_eq!(note, format!("{} fit.", told["matching"]), "after step {step}");
        let sentence = text(browser, "#sentence");
        assert!(sentence.starts_with(&format!("In step {step},")), "{sentence}");
    }
    // Many moves in a row end with the last.
    browser.eval(
        "for (const step of [10, 20, 30, 50]) { const slider = document.getElementById('slider'); \
         slider.value = String(step); slider.dispatchEvent(new Event('input')) }",
    );
    browser.until("document.body.dataset.shown === '50'");
    click(browser, "#present");
    browser.until("document.body.dataset.shown === undefined && !document.body.classList.contains('past')");
    assert_eq!(browser.errors, Vec::<String>::new());
}

#[test]
fn a_memory_on_disk_is_looked_into_and_a_wrong_address_is_refused() {
    let Some(mut browser) = Browser::launch() else { return };
    let house = House::new();
    let life = house.life(100);
    let (_view, at) = house.view(&["--data", life.to_str().unwrap()]);
    browser.go(&at.url);
    browser.until("document.getElementById('when').textContent.includes('rebuilt')");
    let last = number(&mut browser, "Number(document.body.dataset.shown)");
    assert!(last >= 100, "{last}");
    shows(&mut browser, 60);
    assert_eq!(
        browser.eval("document.getElementById('controls').hidden"),
        Value::Bool(true),
        "there is nobody to order"
    );
    assert!(text(&mut browser, "#figures").contains("step60"));
    assert_eq!(browser.errors, Vec::<String>::new());

    browser.go(&at.url.replace(&at.token, &"0".repeat(32)));
    browser.until("document.body.textContent.includes('that is not the whole address')");
}

#[test]
fn it_can_be_used_by_keyboard_and_on_a_narrow_screen() {
    let Some(mut browser) = Browser::launch() else { return };
    let house = House::new();
    let life = house.life(60);
    let (_view, at) = house.view(&["--data", life.to_str().unwrap()]);
    browser.look(400, 800, false);
    browser.go(&at.url);
    browser.until("document.getElementById('when').textContent.includes('rebuilt')");
    let wide = browser.eval("document.documentElement.scrollWidth");
    assert!(wide.as_u64() <= Some(400), "nothing stands out to the right: {wide}");
    // Everything that can be used has a name.
    let unnamed = browser.eval(
        "[...document.querySelectorAll('button, input, select')].filter((one) => \
         !(one.textContent.trim() || one.getAttribute('aria-label') || one.labels?.length)).map((one) => one.outerHTML)",
    );
    assert_eq!(unnamed, Value::Array(Vec::new()));
    browser.eval("document.getElementById('slider').focus()");
    assert_eq!(browser.eval("document.activeElement.id"), "slider");
}
