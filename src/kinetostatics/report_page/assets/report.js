"use strict";
/* A picture of the scene, for paper: a page inside a page that moves cannot be printed everywhere. */
(() => {
  const frame = document.querySelector(".scene iframe"), still = document.querySelector(".still");
  const take = () => {
    const scene = frame.contentWindow && frame.contentWindow.robot_page;
    if (scene && scene.ready) still.src = scene.picture();
  };
  frame.addEventListener("load", take);
  addEventListener("beforeprint", take);
  take();
})();
