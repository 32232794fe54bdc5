(()=>{const s=document.currentScript.closest('svg'),v=s.viewBox.baseVal,w=v.width,h=v.height;let p=null;
const near=()=>s.classList.toggle('near',s.getBoundingClientRect().width/v.width>2.6);
const at=e=>{const m=s.getScreenCTM().inverse();return new DOMPoint(e.clientX,e.clientY).matrixTransform(m)};
s.addEventListener('wheel',e=>{e.preventDefault();const c=at(e),k=Math.min(Math.max(Math.exp(e.deltaY*.0015),w/80/v.width),w*1.2/v.width);
v.x=c.x-(c.x-v.x)*k;v.y=c.y-(c.y-v.y)*k;v.width*=k;v.height*=k;near()},{passive:false});
s.addEventListener('pointerdown',e=>{p=at(e)});addEventListener('pointerup',()=>{p=null});
s.addEventListener('pointermove',e=>{if(p){const c=at(e);v.x+=p.x-c.x;v.y+=p.y-c.y}});
s.addEventListener('dblclick',()=>{v.x=0;v.y=0;v.width=w;v.height=h;near()});
s.querySelectorAll('.node').forEach(n=>{const k=n.id.slice(1),l=[...s.querySelectorAll('.f'+k+',.t'+k)];if(!l.length)return;
n.addEventListener('pointerenter',()=>{s.classList.add('dim');l.forEach(x=>x.classList.add('lit'))});
n.addEventListener('pointerleave',()=>{s.classList.remove('dim');l.forEach(x=>x.classList.remove('lit'))})});near()})()
