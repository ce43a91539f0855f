
%satuan panjang dalam mm
r1=180; %panjang batang 1
r2=100; %panjang batang 2
r3=300; %panjang batang 3
r5=90; %panjang batang 5
s0=186.1818 %titik acuan=0, untuk posisiC

%kecepatan sudut batang 2 konstan = 40 rpm

%Analisis posisi



theta2=(0:1:360)*pi/180; %sudut batang dua
theta3a=asin((r1-r5-r2.*sin(theta2))./(r3));%sudut batang 3
theta3b=pi-theta3a; %sudut batang 3
rp=r1^2+r2^2-2*r1*r2*sin(theta2);
theta_p=asin((r1-r2*sin(theta2);
posisiC=((r2*cos(theta2))+(r3*cos(theta3b)))+s0; %posisi titik C akibat input putaran batang 2



%Analisis kecepatan dan percepatan
w2=input('putaran input = ');%kecepatan sudut batang 2 (omega2)
w3=-w2*((r2*cos(theta2))/(r3*cos(theta3b)));



%kecepatan sudut batang 3 (omega3)
Kecepatan
C=-r2*w2*sin(theta2)-(r3*w3*sin(theta3b));
a3=(r2*w2^2*sin(theta2))/(r3*cos(theta3b))+w3^2*sin(theta3b)/(cos(theta3b));
%percepatan sudut batang 3 (alpha3)
Percepatan
C=(-r2*w2^2*cos(theta2))-r3*((w3^2*cos(theta3b))+(a3*sin(theta3b)));
theta2*180/pi
theta3*180/pi
posisiC
kecepatanC
percepatanC
figure(2);plot(real(posisiC), imag(posisiC));
xlabel('real');
ylabel('imaginer');
title('lintasan posisi C');
grid on;
figure(3);plot(theta2*180/pi, theta3*180/pi);
xlabel('theta2');
ylabel('theta3');
title('posisi theta3 versus theta2');
grid on;
figure(4);plot(theta2*180/pi, kecepatanC);
xlabel('theta2');
ylabel('kecepatanC');
title('kecepatanC versus theta2');
grid on;
figure(5);plot(theta2*180/pi, percepatanC);
xlabel('theta2');
ylabel('percepatanC');
title('percepatanC versus theta2');
grid on;

