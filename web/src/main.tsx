import { render } from "preact";
import { App } from "./App";
import { store } from "./store";
import "./style.css";

const page = document.getElementById("page");
if (page) render(<App />, page);
store.connect();
