import "../styles/studio.css";

const app = document.getElementById("app");
if (app) app.textContent = "patinate studio";
