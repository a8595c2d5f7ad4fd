"use strict";
/* A picture of the scene, for paper: a page inside a page that moves cannot be printed everywhere. */
(() => {
  const frame = document.querySelector(".scene iframe"), still = document.querySelector(".still");
  const take = () => {
    const scene = frame.contentWindow && frame.contentWindow.robot_page;
    if (scene && scene.ready) still.src = scene.picture();
  };
  addEventListener("message", take); // the scene tells when it is drawn
  addEventListener("beforeprint", take);
  take();
})();
