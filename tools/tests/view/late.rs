//! The page, in a real browser, when answers come in another order than was asked, or not at all.

use crate::browser::Browser;
use crate::forged::unlike;
use crate::house::House;

/// From here on, answers to what contains `window.slow` are kept back until they are let go.
const KEEP_BACK: &str = "(() => {
    const real = window.fetch;
    window.kept = [];
    window.slow = null;
    window.fetch = async (to, what) => {
        const late = window.slow !== null && what.body.includes(window.slow);
        const reply = await real(to, what);
        const answer = await reply.json();
        if (late) await new Promise((done) => window.kept.push(done));
        return { ok: reply.ok, status: reply.status, json: async () => answer };
    };
})()";

/// Does something the answer to which is kept back.
fn slowly(browser: &mut Browser, asking: &str, action: &str) {
    browser.eval(&format!("window.slow = {asking:?}; {action}"));
    browser.until("window.kept.length === 1");
    browser.eval("window.slow = null");
}

/// The answer arrives; all that follows from it is done when the browser answers next.
fn arrives(browser: &mut Browser) {
    browser.eval("window.kept.pop()()");
    browser.eval("0");
}

fn text(browser: &mut Browser, id: &str) -> String {
    browser.eval(&format!("document.getElementById('{id}').textContent")).as_str().unwrap().to_owned()
}

fn picks(row: usize) -> String {
    format!("document.querySelectorAll('#list button')[{row}].click()")
}

/// The title that a row of the list leads to.
fn title(browser: &mut Browser, row: usize) -> String {
    let id = browser.eval(&format!("document.querySelectorAll('#list button')[{row}].textContent"));
    format!("Schema {}", id.as_str().unwrap())
}

fn draws(around: u32) -> String {
    format!(
        "document.querySelector('#draw [name=around]').value = '{around}'; \
         document.querySelector('#draw button').click()"
    )
}

fn goes_to(step: u64) -> String {
    format!(
        "document.getElementById('slider').value = '{step}'; \
         document.getElementById('slider').dispatchEvent(new Event('input'))"
    )
}

#[test]
fn a_late_answer_does_not_replace_a_newer_one() {
    let Some(mut browser) = Browser::launch() else { return };
    let house = House::new();
    let life = house.life(100);
    let (_view, at) = house.view(&["--data", life.to_str().unwrap()]);
    browser.go(&at.url);
    browser.until("document.getElementById('when').textContent.includes('rebuilt')");
    browser.until("document.querySelectorAll('#list button').length > 5");
    browser.eval(KEEP_BACK);

    // One schema is picked, then another.
    let ask = r#""ask":"show""#;
    let wanted = title(&mut browser, 4);
    slowly(&mut browser, ask, &picks(2));
    browser.eval(&picks(4));
    browser.until(&format!("document.getElementById('one-title').textContent === '{wanted}'"));
    arrives(&mut browser);
    assert_eq!(text(&mut browser, "one-title"), wanted);

    // A refusal that is late is not told either.
    slowly(&mut browser, r#""ask":"graph""#, &draws(99_999));
    browser.eval(&draws(4));
    browser.until("document.getElementById('graph-note').textContent.startsWith('Step ')");
    let note = text(&mut browser, "graph-note");
    arrives(&mut browser);
    assert_eq!(text(&mut browser, "graph-note"), note);

    // A schema is picked, and another moment is gone to before it is there: it is shown as it was then.
    let wanted = title(&mut browser, 3);
    slowly(&mut browser, ask, &picks(3));
    browser.eval(&goes_to(50));
    browser.until("document.body.dataset.shown === '50' && document.getElementById('when').textContent.includes('rebuilt')");
    browser.eval("document.getElementById('whole').firstChild.id = 'then'");
    arrives(&mut browser);
    assert_eq!(text(&mut browser, "one-title"), wanted);
    assert_eq!(
        browser.eval("document.getElementById('then') !== null"),
        true,
        "nothing was put in its place"
    );
}

#[test]
fn the_curve_has_each_step_once() {
    let Some(mut browser) = Browser::launch() else { return };
    let house = House::new();
    let life = house.life(20);
    let (_view, at) = house.view(&["--data", life.to_str().unwrap()]);
    browser.go(&at.url);
    browser.until("document.getElementById('when').textContent.includes('rebuilt')");
    let points = browser.eval(
        "import('./trace.js').then((trace) => {
            const decision = (excitation_top) => ({ excitation_top, predicts: [] });
            const record = (step) => ({ step, stage: 0, decision: decision(step), perceived: [], heard: [] });
            const page = { total: 5, from: 0, records: [1, 2, 3, 4, 5].map(record) };
            trace.take({ total: 5, from: 5, records: [] });
            trace.take(page);
            trace.take(page);
            trace.show();
            return document.querySelector('#trace path.c0').getAttribute('d').match(/[ML]/g).length;
        })",
    );
    assert_eq!(points, 5);
}

#[test]
fn a_decision_that_can_not_be_made_again_is_said_in_its_place() {
    let Some(mut browser) = Browser::launch() else { return };
    let house = House::new();
    let life = house.life(60);
    let last = unlike(&life);
    let (_view, at) = house.view(&["--data", life.to_str().unwrap()]);
    browser.go(&at.url);
    browser.until("document.getElementById('when').textContent.includes('rebuilt')");
    assert_eq!(browser.eval("document.body.dataset.shown"), last.to_string());
    let sentence = text(&mut browser, "sentence");
    assert!(sentence.contains("can't be explained"), "{sentence}");
    assert!(text(&mut browser, "schemas-note").ends_with(" fit."));
    browser.eval(&goes_to(40));
    browser.until("document.getElementById('sentence').textContent.startsWith('In step 40,')");
    assert_eq!(browser.errors, Vec::<String>::new());
}
