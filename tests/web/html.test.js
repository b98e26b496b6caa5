import assert from "node:assert";
import { readdirSync, readFileSync } from "node:fs";
import test from "node:test";
import { Html, html, put } from "../../app/web/shared/text.js";

test("a value in markup is escaped, and markup in markup is not", () => {
  const name = `<img onerror="x">'`;
  const rows = [name, "b & c"].map((one) => html`<li>${one}</li>`);
  assert.equal(
    String(html`<ul title="${name}">${rows}</ul>`),
    `<ul title="&lt;img onerror=&quot;x&quot;&gt;&#39;"><li>&lt;img onerror=&quot;x&quot;&gt;&#39;</li><li>b &amp; c</li></ul>`,
  );
});

test("what is absent is left out, and zero is not", () => {
  assert.equal(String(html`${null}${undefined}${false}${""}${0}${[]}`), "0");
});

test("only markup that html made is written into the page", () => {
  const box = { innerHTML: "" };
  put(box, html`<b>${1}</b>`);
  assert.equal(box.innerHTML, "<b>1</b>");
  assert.throws(() => put(box, "<b>1</b>"), /every value is escaped/);
  assert.ok(html`x` instanceof Html);
});

test("markup is written in one place", () => {
  const web = new URL("../../app/web/", import.meta.url);
  const scripts = readdirSync(web, { recursive: true, encoding: "utf8" }).filter((name) => name.endsWith(".js"));
  const writers = scripts.filter((name) =>
    /innerHTML|outerHTML|insertAdjacentHTML/.test(readFileSync(new URL(name, web), "utf8")),
  );
  assert.deepEqual(writers, ["shared/text.js"]);
});
